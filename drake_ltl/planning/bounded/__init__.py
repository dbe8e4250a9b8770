"""Bounded planning: lassos of limited length as a constraint model, for teams too large to enumerate."""

from drake_ltl.planning.bounded.planner import Progress, plan_bounded

__all__ = ["Progress", "plan_bounded"]
