"""What everybody should do in each step of a plan, by the verdict's own rules: no code of the controllers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from drake_ltl.scenario.model import Region, Scenario
from drake_ltl.verification.expected import Expected, expectations
from drake_ltl.verification.regions import ROUNDING
from drake_ltl.verification.roles import Roles, step_roles
from drake_ltl.verification.spans import Span


@dataclass(frozen=True)
class Duty:
    """What a step demands: where everybody is before and after it, and who does what."""

    before: Expected
    after: Expected
    roles: Roles

    @property
    def rest(self) -> Duty:
        """Where it begins, with nothing to do."""
        return Duty(self.before, self.before, Roles((), (), {}, self.roles.exempt))


def duties(start: Expected, steps: Sequence[Sequence[Mapping[str, Any]]]) -> tuple[Duty, ...]:
    """Of each step, in order of execution.

    Args:
        start: where everybody is at the start.
        steps: the actions of each step, see `execution.recording.StepRecord`.
    """
    spans = [Span(number, tuple(map(dict, actions)), 0, 0, 0, True) for number, actions in enumerate(steps)]
    expected = expectations(start, spans)
    return tuple(
        Duty(before, after, step_roles(before, span))
        for before, after, span in zip(expected, expected[1:], spans, strict=False)
    )


@dataclass(frozen=True)
class Members:
    """All members as spheres, in the order in which monitors have their centres: agents, then objects."""

    agents: tuple[str, ...]
    objects: tuple[str, ...]
    agent_radius: Mapping[str, float]
    object_radius: Mapping[str, float]
    team_radius: Mapping[str, float]

    @property
    def names(self) -> tuple[str, ...]:
        return self.agents + self.objects

    @property
    def radii(self) -> np.ndarray:
        """r_i of the agents and r_j^O of the objects (N + M,) [m]."""
        return np.array([self.agent_radius[a] for a in self.agents] + [self.object_radius[o] for o in self.objects])


def regions_of(members: Members, scenario: Scenario, centres: np.ndarray) -> dict[str, str | None]:
    """member -> the region that contains its sphere, None outside all. Regions do not overlap.

    Args:
        centres: (N + M, 3) [m] in W.
    """
    rows = zip(members.names, centres, members.radii.tolist(), strict=True)
    return {name: _region_at(scenario.regions, p, radius) for name, p, radius in rows}


def expected_start(members: Members, scenario: Scenario, centres: np.ndarray) -> Expected:
    """Regions are read off the poses at the start; nobody grasps anything yet."""
    found = regions_of(members, scenario, centres)
    return Expected(
        agents={name: found[name] for name in members.agents},
        objects={name: found[name] for name in members.objects},
        grasps=dict.fromkeys(members.agents),
    )


def _region_at(regions: Sequence[Region], p: np.ndarray, radius: float) -> str | None:
    inside = (r.name for r in regions if np.linalg.norm(p - np.array(r.centre)) + radius - r.radius <= ROUNDING)
    return next(inside, None)
