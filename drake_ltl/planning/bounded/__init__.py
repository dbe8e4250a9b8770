"""Bounded planning: lassos of limited length as a constraint model, for teams too large to enumerate."""

from drake_ltl.planning.bounded.planner import plan_bounded
from drake_ltl.planning.bounded.standing import Progress

__all__ = ["Progress", "plan_bounded"]
