"""What monitors hold a run against while it goes on: pure functions on immutable data, without Drake.

The systems that watch with them are in `drake_ltl.systems.monitors`.
"""
