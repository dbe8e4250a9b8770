"""What is found out on the way and forbidden from then on: contents, teams, transitions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from drake_ltl.planning.fits import Content
from drake_ltl.planning.plan import State

if TYPE_CHECKING:
    from drake_ltl.planning.bounded.lassos import Lassos, Literal


@dataclass(frozen=True)
class Cut:
    """A content that does not fit, anywhere where all of it (and more) stands in the region."""

    region: int
    content: Content


@dataclass(frozen=True)
class WeakTeam:
    """A team that cannot carry an object."""

    object: int
    team: frozenset[int]


def forbid(lassos: Lassos, cut: Cut) -> None:
    """No position shows all of a content in a region; what is carried, only as it leaves or arrives."""
    for t in range(lassos.horizon + 1):
        stands = _stands(lassos, t, cut)
        if not cut.content.carried:
            lassos.model.add_bool_or(literal.negated() for literal in stands)
            continue
        for step in {t - 1, t} & set(range(lassos.horizon)):
            index = lassos.problem.scenario.object_names.index
            carried = [lassos.carried[step][index(obj)] for obj in cut.content.carried]
            lassos.model.add_bool_or(literal.negated() for literal in stands + carried)


def forbid_team(lassos: Lassos, weak: WeakTeam) -> None:
    """Exactly this team never carries the object."""
    for t in range(lassos.horizon):
        differs = [
            lassos.grasps[t][i][weak.object].negated() if i in weak.team else lassos.grasps[t][i][weak.object]
            for i in range(lassos.problem.n_agents)
        ]
        lassos.model.add_bool_or([lassos.carried[t][weak.object].negated(), *differs])


def forbid_transition(lassos: Lassos, before: State, after: State) -> None:
    """No active step leads from a state to another."""
    for t in range(lassos.horizon):
        shown = lassos.shown(t, before) + lassos.shown(t + 1, after)
        lassos.model.add_bool_or([lassos.active[t].negated(), *(literal.negated() for literal in shown)])


def _stands(lassos: Lassos, t: int, cut: Cut) -> list[Literal]:
    scenario, n = lassos.problem.scenario, lassos.problem.n_agents
    agent, obj = scenario.agent_names.index, scenario.object_names.index
    free = [lassos.free[t][agent(name)][cut.region] for name in cut.content.free_agents]
    objects = [lassos.at[t][n + obj(name)][cut.region] for name in cut.content.objects]
    return free + objects + [lassos.grasps[t][agent(a)][obj(o)] for a, o in cut.content.holds]
