"""Exit statuses of the commands."""

SUCCESS = 0
FAILURE = 1
"""Violated, or infeasible."""
BAD_INPUT = 2
INTERRUPTED = 130
"""By Ctrl-C or SIGTERM."""
