"""What a planner returns: states, actions and the lasso prefix (suffix)^omega."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

from drake_ltl.shown import Shown

if TYPE_CHECKING:
    from rich.console import RenderableType

ActionKind = Literal["travel", "grasp", "release", "transport"]


@dataclass(frozen=True)
class State:
    """pi_s = (pi_k1 .. pi_kN, pi_k1^O .. pi_kM^O, w_1 .. w_N) of Def. 5, by names in the scenario's order."""

    agents: tuple[str, ...]
    """Region of each agent."""
    objects: tuple[str, ...]
    """Region of each object."""
    grasps: tuple[str | None, ...]
    """Object that each agent grasps, or None."""


@dataclass(frozen=True)
class Action:
    """One of the actions that a move of the plan consists of. Agents that do nothing have none."""

    kind: ActionKind
    agents: tuple[str, ...]
    """The agent that acts; a transport's whole team T."""
    start: str
    """Region in which it begins."""
    goal: str
    """Region in which it ends (that of `start` for a grasp and a release)."""
    object: str | None = None
    """What is grasped, released or carried; None for a travel."""


@dataclass(frozen=True)
class Plan(Shown):
    """A lasso: the run is prefix, then suffix for ever; the suffix's last state leads back to its first.

    `prefix` begins with the initial state, or is empty when the suffix does. `moves[l]` are the actions between
    states l and l + 1 of prefix + suffix; the last entry leads back to suffix[0].
    """

    prefix: tuple[State, ...]
    suffix: tuple[State, ...]
    moves: tuple[tuple[Action, ...], ...]
    prefix_cost: float
    suffix_cost: float
    lower_bound: float
    status: Literal["optimal", "feasible"]
    alpha: float = 1.0
    """Weight of the prefix's cost in J."""
    beta: float = 1.0
    """Weight of the suffix's cost in J."""
    counts: Mapping[str, int | None] = field(default_factory=dict, compare=False)
    seconds: Mapping[str, float] = field(default_factory=dict, compare=False)

    def __repr__(self) -> str:
        steps = f"{len(self.prefix)} steps, then {len(self.suffix)} for ever"
        return f"Plan({self.status}, J = {self.cost:g}, {steps})"

    def __rich__(self) -> RenderableType:
        from drake_ltl.planning.table import plan_table

        return plan_table(self)

    @property
    def cost(self) -> float:
        """J = alpha cost(prefix) + beta cost(suffix)."""
        return self.alpha * self.prefix_cost + self.beta * self.suffix_cost

    @property
    def states(self) -> tuple[State, ...]:
        """All states once: prefix, then suffix."""
        return self.prefix + self.suffix

    @property
    def loop(self) -> int:
        """Index in `states` to which the last move leads."""
        return len(self.prefix)
