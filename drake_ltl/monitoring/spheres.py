"""Bounding spheres in a step of a plan: which must be apart, where they must stay. All pairs in one array expression.

Who must keep apart from what is worked out once for a step; then each look is a few operations on arrays. Balls are
those of the verdict: an object that is carried and its team are one ball of radius r_{T,j} about the object's origin,
and the members of one team are held against each other as agents.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from drake_ltl.monitoring.duties import Duty, Members
from drake_ltl.monitoring.violation import Finding
from drake_ltl.scenario.model import Scenario
from drake_ltl.verification.expected import Expected
from drake_ltl.verification.regions import ROUNDING


@dataclass(frozen=True)
class Rule:
    """Distances that must not be less, or not be more, than their limits (n rows).

    Row k is the distance of ball a_k from ball b_k, or from a fixed point where b_k is negative.
    """

    name: tuple[str, ...]
    a: np.ndarray
    b: np.ndarray
    point: np.ndarray
    """(n, 3) [m] in W; used where b < 0."""
    limit: np.ndarray
    """(n,) [m]: radii added up, or taken from one another."""
    sign: np.ndarray
    """(n,) 1: what is left is distance - limit, which must be positive; -1: limit - distance, which must not be
    negative."""
    who: tuple[tuple[str, ...], ...]
    what: tuple[str, ...]

    @staticmethod
    def joined(rules: Sequence[Rule]) -> Rule:
        """All rows of some rules."""
        arrays = ("a", "b", "point", "limit", "sign")
        texts = ("name", "who", "what")
        return Rule(
            **{key: np.concatenate([getattr(rule, key) for rule in rules]) for key in arrays},
            **{key: tuple(row for rule in rules for row in getattr(rule, key)) for key in texts},
        )

    def left(self, centres: np.ndarray) -> np.ndarray:
        """(n,) clearances [m] of balls with centres (N + M, 3)."""
        ends = np.concatenate([self.point, centres])  # so that row k's point is its k-th end
        offset = ends[self._a] - ends[self._b]
        return self.sign * (np.sqrt(np.einsum("ij,ij->i", offset, offset)) - self.limit)

    def findings(self, centres: np.ndarray) -> Iterator[Finding]:
        """Rows that are violated."""
        left = self.left(centres)
        for row in np.flatnonzero(left <= self._least).tolist():
            yield Finding(self.who[row], self.what[row], float(left[row]), 0.0, "m", self.name[row])

    @cached_property
    def _a(self) -> np.ndarray:
        """(n,) indices of ends."""
        return self.a + len(self.point)

    @cached_property
    def _b(self) -> np.ndarray:
        return np.where(self.b < 0, np.arange(len(self.b)), self.b + len(self.point))

    @cached_property
    def _least(self) -> np.ndarray:
        """What is left where a row is violated (n,)."""
        return np.where(self.sign > 0.0, 0.0, -ROUNDING)


def apart(duty: Duty, members: Members) -> Rule:
    """All pairs of balls but those that touch by intention."""
    rows = []
    for a, b in combinations(_balls(duty, members), 2):
        if (a[0], b[0]) not in duty.roles.exempt:
            rows.append((a, b))
    for transport in duty.roles.transports:
        team = [(name, members.agent_radius[name], name) for name in transport.team]
        rows += combinations(team, 2)
    number = {name: index for index, name in enumerate(members.names)}
    return Rule(
        name=("clearance",) * len(rows),
        a=np.array([number[a] for (a, _, _), _ in rows], dtype=int),
        b=np.array([number[b] for _, (b, _, _) in rows], dtype=int),
        point=np.zeros((len(rows), 3)),
        limit=np.array([r + s for (_, r, _), (_, s, _) in rows]),
        sign=np.ones(len(rows)),
        who=tuple((a, b) for (a, _, _), (b, _, _) in rows),
        what=tuple(f"{a} and {b} overlap" for (_, _, a), (_, _, b) in rows),
    )


def forbidden(duty: Duty, members: Members, scenario: Scenario) -> Rule:
    """Balls on their way touch no region but those they start and end in (Defs. 1 and 4)."""
    radius = {name: r for name, r, _ in _balls(duty, members)}
    rows = [
        (mover, region)
        for mover in duty.roles.movers
        for region in scenario.regions
        if region.name not in (mover.start, mover.goal)
    ]
    return _from_points(
        "forbidden_region",
        members,
        [(mover.name, region.centre, radius[mover.name] + region.radius) for mover, region in rows],
        1.0,
        tuple((mover.name, region.name) for mover, region in rows),
        tuple(f"{mover} touches {region.name} on the way to {mover.goal}" for mover, region in rows),
    )


def workspace(duty: Duty, members: Members, scenario: Scenario) -> Rule:
    """All balls stay within the workspace, a ball about the world's origin."""
    balls = list(_balls(duty, members))
    return _from_points(
        "workspace",
        members,
        [(name, (0.0, 0.0, 0.0), scenario.workspace_radius - radius) for name, radius, _ in balls],
        -1.0,
        tuple((name,) for name, _, _ in balls),
        tuple(f"{text} leaves the workspace" for _, _, text in balls),
    )


def staying(duty: Duty, members: Members, scenario: Scenario) -> Rule:
    """Who does not move is in its region all the time."""
    names = [name for name in members.names if name not in duty.roles.moving]
    return _inside(members, scenario, duty.before, names, "{} is not in {}")


def arrived(duty: Duty, members: Members, scenario: Scenario) -> Rule:
    """Who moved is in its goal region when the step ends."""
    names = [name for name in members.names if name in duty.roles.moving]
    return _inside(members, scenario, duty.after, names, "{} has not come to {}")


def _inside(members: Members, scenario: Scenario, expected: Expected, names: list[str], text: str) -> Rule:
    """Spheres within the regions where they are expected; who is expected in none may be anywhere."""
    radius = {**members.agent_radius, **members.object_radius}
    rows = [(name, scenario.region(place)) for name in names if (place := expected.region(name)) is not None]
    return _from_points(
        "region",
        members,
        [(name, region.centre, region.radius - radius[name]) for name, region in rows],
        -1.0,
        tuple((name, region.name) for name, region in rows),
        tuple(text.format(name, region.name) for name, region in rows),
    )


def _balls(duty: Duty, members: Members) -> Iterator[tuple[str, float, str]]:
    """(whose centre, radius, name for people); agents before objects, so that a pair of both is (agent, object)."""
    for name in members.agents:
        if name not in duty.roles.carriers:
            yield name, members.agent_radius[name], name
    for name in members.objects:
        if name not in duty.roles.carried:
            yield name, members.object_radius[name], name
    for mover in duty.roles.transports:
        yield mover.name, members.team_radius[mover.name], str(mover)


def _from_points(kind: str, members: Members, rows: list, sign: float, who: tuple, what: tuple) -> Rule:
    """Of rows (whose centre, point, limit)."""
    number = {name: index for index, name in enumerate(members.names)}
    return Rule(
        name=(kind,) * len(rows),
        a=np.array([number[name] for name, _, _ in rows], dtype=int),
        b=np.full(len(rows), -1),
        point=np.array([point for _, point, _ in rows], dtype=float).reshape(-1, 3),
        limit=np.array([limit for _, _, limit in rows], dtype=float),
        sign=np.full(len(rows), sign),
        who=who,
        what=what,
    )
