"""Symbolic planning: transition system, automata, optimal lasso search, and where the bodies of a plan stand.

Nothing is loaded with the package itself: who needs its numbers alone (`geometry`) needs no solver.
"""
