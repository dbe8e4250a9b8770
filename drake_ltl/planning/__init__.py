"""Symbolic planning: transition system, automata, optimal lasso search, and where the bodies of a plan stand."""

from drake_ltl.planning.certificate import check
from drake_ltl.planning.plan import Action, Plan, State
from drake_ltl.planning.planner import plan

__all__ = ["Action", "Plan", "State", "check", "plan"]
