"""A plan with a place for every body at every state: what the continuous half carries out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from drake_ltl.planning.geometry import Vector3
from drake_ltl.planning.plan import Action, Plan
from drake_ltl.shown import Shown

if TYPE_CHECKING:
    from rich.console import RenderableType


@dataclass(frozen=True)
class Stand:
    """Where one agent stands at a plan state."""

    p_WC: Vector3
    """Centre of its bounding sphere in W."""
    posture: str
    """Key into `Geometry.postures`; for a grasping agent the stand-off posture of its grasp option."""
    grasp: tuple[str, str] | None = None
    """(object, name of the grasp option) while it grasps."""


@dataclass(frozen=True)
class Layout:
    """Where all bodies stand at one plan state."""

    agents: Mapping[str, Stand]
    objects: Mapping[str, Vector3]
    """Origin of each object in W."""
    headings: Mapping[str, float] = field(default_factory=dict)
    """Yaw of each object [rad]."""


@dataclass(frozen=True)
class PlacedStep:
    """One move of the plan, from one layout to the next."""

    actions: tuple[Action, ...]
    before: Layout
    after: Layout
    standoffs: Mapping[str, Stand]
    """For each agent that grasps in this step: the stand-off from which it approaches."""


@dataclass(frozen=True)
class Mission(Shown):
    """Placed steps; after the last one the run continues with `steps[loop]`, for ever.

    The placed loop may begin later than the plan's: its first round can differ where a body returns to another
    place of its region than the one it started from. `steps[loop].before` equals `steps[-1].after`.
    """

    plan: Plan
    steps: tuple[PlacedStep, ...]
    loop: int

    def __repr__(self) -> str:
        return f"Mission({len(self.steps)} placed steps, loop from step {self.loop + 1}, {self.plan!r})"

    def __rich__(self) -> RenderableType:
        return self.plan.__rich__()
