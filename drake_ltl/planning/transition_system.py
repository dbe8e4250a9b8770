"""The transition system TS of Def. 5, all of it, as arrays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drake_ltl.errors import InvalidInputError, Mistake, SearchLimitError
from drake_ltl.planning.contents import Fitting
from drake_ltl.planning.costs import Chi, region_costs
from drake_ltl.planning.fits import Fits
from drake_ltl.planning.plan import State
from drake_ltl.planning.power import CanCarry
from drake_ltl.scenario.model import Scenario

MOST_COMBINATIONS = 2_000_000
MOST_TRANSITIONS = 20_000_000
"""Beyond these sizes TS is not enumerated: some hundred bytes each."""


@dataclass(frozen=True, eq=False)
class TransitionSystem:
    """States Pi_s (S of them) and transitions (E of them, sorted by source) of Def. 5.

    An agent that grasps is where its object is, so a state is one option per agent (free in one of K regions,
    or grasping one of M objects) and one region per object.
    """

    scenario: Scenario
    options: NDArray[np.int64]
    """(S, N): k < K for an agent that is free in region k, K + j for one that grasps object j."""
    places: NDArray[np.int64]
    """(S, M): region of each object."""
    sources: NDArray[np.int64]
    """(E,): state in which a transition begins; non-decreasing."""
    targets: NDArray[np.int64]
    """(E,): state in which it ends."""
    costs: NDArray[np.float64]
    """(E,): chi."""
    index_of_code: NDArray[np.int64]
    """Index of the state with a given code, or -1."""
    n_formed: int
    """Number of transitions of Def. 5, before any were left out (`keep`)."""

    @property
    def n_states(self) -> int:
        return len(self.options)

    @property
    def n_transitions(self) -> int:
        return len(self.sources)

    @property
    def agent_regions(self) -> NDArray[np.int64]:
        """(S, N): region of each agent."""
        return _agent_regions(self.options, self.places, len(self.scenario.regions))

    @property
    def actions(self) -> NDArray[np.int64]:
        """(E,): how many agents act in each transition."""
        bodies = np.hstack([self.options, self.agent_regions])
        changed = bodies[self.sources] != bodies[self.targets]
        n_agents = self.options.shape[1]
        return (changed[:, :n_agents] | changed[:, n_agents:]).sum(axis=1)

    def state(self, index: int) -> State:
        """The state with a given index, by names."""
        scenario = self.scenario
        regions, objects = scenario.region_names, scenario.object_names
        places = self.places[index].tolist()
        agents, grasps = [], []
        for option in self.options[index].tolist():
            held = option - len(regions)
            agents.append(regions[option if held < 0 else places[held]])
            grasps.append(None if held < 0 else objects[held])
        return State(tuple(agents), tuple(regions[k] for k in places), tuple(grasps))

    def index(self, state: State) -> int:
        """The index of a state; -1 if it does not belong to Pi_s.

        Raises:
            InvalidInputError: the state speaks of other members or regions than the scenario.
        """
        scenario = self.scenario
        regions = {name: k for k, name in enumerate(scenario.region_names)}
        objects = {name: len(regions) + j for j, name in enumerate(scenario.object_names)}
        numbers = (len(state.agents), len(state.grasps), len(state.objects))
        unknown = {*state.agents, *state.objects} - set(regions) | set(state.grasps) - {None, *objects}
        if numbers != (len(scenario.agents), len(scenario.agents), len(scenario.objects)) or unknown:
            what = f"does not belong to the scenario: {state}"
            remedy = f"regions are {', '.join(regions)}; objects are {', '.join(objects) or 'none'}"
            raise InvalidInputError([Mistake("state", what, remedy)])
        held = dict(zip(scenario.object_names, state.objects, strict=True))
        pairs = list(zip(state.agents, state.grasps, strict=True))
        if any(grasp is not None and held[grasp] != region for region, grasp in pairs):
            return -1  # Def. 5 (i): an agent is where the object is that it grasps
        options = [regions[region] if grasp is None else objects[grasp] for region, grasp in pairs]
        places = [regions[region] for region in state.objects]
        code = _codes([np.array([v]) for v in options + places], _bases(scenario))
        return int(self.index_of_code[code[0]])

    def without(self, forbidden: frozenset[tuple[State, State]]) -> TransitionSystem:
        """The same without some transitions; pairs that are none are ignored."""
        if not forbidden:
            return self
        pairs = {(self.index(before), self.index(after)) for before, after in forbidden}
        keys = np.array([before * self.n_states + after for before, after in pairs if min(before, after) >= 0])
        return self.keep(~np.isin(self.sources * self.n_states + self.targets, keys))

    def keep(self, kept: NDArray[np.bool_]) -> TransitionSystem:
        """The same with only some transitions, (E,)."""
        return replace(self, sources=self.sources[kept], targets=self.targets[kept], costs=self.costs[kept])


def form(scenario: Scenario, fits: Fits, can_carry: CanCarry, chi: Chi | None = None) -> TransitionSystem:
    """Enumerate TS.

    Args:
        scenario: regions, agents and objects.
        fits: P_s; besides the states it filters the transports (`Content.carried`).
        can_carry: Lambda.
        chi: cost of a transition; None takes the scenario's `cost`.

    Raises:
        SearchLimitError: there are too many states or transitions.
        InvalidInputError: chi returned a cost that is negative or not finite.
    """
    fitting = Fitting(scenario, fits)
    options, places, index_of_code = _states(scenario, fitting)
    sources, targets = _transitions(scenario, can_carry, options, places, index_of_code)
    moved = places[sources] != places[targets]
    fit = _transports_fit(fitting, options, places, sources, targets, moved)
    sources, targets = sources[fit], targets[fit]
    bodies = np.hstack([_agent_regions(options, places, len(scenario.regions)), places])
    costs = _sum_of_ways(scenario, bodies, sources, targets)
    system = TransitionSystem(scenario, options, places, sources, targets, costs, index_of_code, len(sources))
    if chi is not None:
        costs[:] = _costs_of(chi, system)
    return system


def _bases(scenario: Scenario) -> list[int]:
    regions, objects = len(scenario.regions), len(scenario.objects)
    return [regions + objects] * len(scenario.agents) + [regions] * objects


def _codes(columns: Sequence[NDArray], bases: Sequence[int]) -> NDArray[np.int64]:
    """Mixed-radix numbers whose digits are the columns."""
    return np.ravel_multi_index(tuple(columns), tuple(bases))


def _agent_regions(options: NDArray, places: NDArray, n_regions: int) -> NDArray[np.int64]:
    grasps = options >= n_regions
    if not grasps.any():
        return options
    held = np.take_along_axis(places, np.where(grasps, options - n_regions, 0), axis=1)
    return np.where(grasps, held, options)


def _states(scenario: Scenario, fitting: Fitting) -> tuple[NDArray, NDArray, NDArray]:
    """Def. 5 (i): all combinations whose regions' contents fit."""
    bases = _bases(scenario)
    if math.prod(bases) > MOST_COMBINATIONS:
        raise SearchLimitError(f"{_size(scenario)} have {math.prod(bases)} states, too many to enumerate")
    digits = np.stack(np.unravel_index(np.arange(math.prod(bases)), bases), axis=1)
    n_agents = len(scenario.agents)
    for region in range(len(scenario.regions)):
        digits = digits[fitting.check(region, digits[:, :n_agents], digits[:, n_agents:])]
    index_of_code = np.full(math.prod(bases), -1)
    index_of_code[_codes(digits.T, bases)] = np.arange(len(digits))
    return digits[:, :n_agents], digits[:, n_agents:], index_of_code


def _transitions(
    scenario: Scenario, can_carry: CanCarry, options: NDArray, places: NDArray, index_of_code: NDArray
) -> tuple[NDArray, NDArray]:
    """Def. 5 (iii): successors of all states at once, one member after the other.

    Each member multiplies the rows by its allowed choices; rows whose target is no state fall out at the end.
    """
    n_regions = len(scenario.regions)
    choices = [_agent_choices(option, places, n_regions) for option in options.T]
    n_choices = np.prod([allowed.sum(axis=1) for allowed in choices], axis=0).sum()
    if n_choices > MOST_TRANSITIONS:
        raise SearchLimitError(f"{_size(scenario)} have some {n_choices} transitions, too many to enumerate")
    rows, after = np.arange(len(options)), np.empty((len(options), 0), dtype=np.int64)
    for allowed in choices:
        rows, after = _multiply(rows, after, allowed[rows])
    stay = np.eye(n_regions, dtype=bool)
    for j in range(len(scenario.objects)):
        movable = _movable(scenario, can_carry, j, options[rows], after[:, : len(scenario.agents)])
        rows, after = _multiply(rows, after, stay[places[rows, j]] | movable[:, None])
    targets = index_of_code[_codes(after.T, _bases(scenario))]
    return rows[targets >= 0], targets[targets >= 0]


def _multiply(rows: NDArray, after: NDArray, allowed: NDArray) -> tuple[NDArray, NDArray]:
    """Each row as often as it has allowed choices, with the choice as one more column."""
    kept, choice = np.nonzero(allowed)
    return rows[kept], np.column_stack([after[kept], choice])


def _size(scenario: Scenario) -> str:
    counts = len(scenario.agents), len(scenario.objects), len(scenario.regions)
    return "{} agents, {} objects and {} regions".format(*counts)


def _agent_choices(option: NDArray, places: NDArray, n_regions: int) -> NDArray[np.bool_]:
    """(S, K + M): what one agent may do next, (iii)(1) to (iii)(3).

    A free agent travels anywhere or grasps an object of its region; one that grasps goes on or releases the
    object where it is.
    """
    n_objects = places.shape[1]
    free = option < n_regions
    allowed = np.zeros((len(option), n_regions + n_objects), dtype=bool)
    allowed[free, :n_regions] = True
    for j in range(n_objects):
        allowed[:, n_regions + j] = (free & (places[:, j] == option)) | (option == n_regions + j)
        holders = np.flatnonzero(option == n_regions + j)
        allowed[holders, places[holders, j]] = True
    return allowed


def _movable(scenario: Scenario, can_carry: CanCarry, j: int, before: NDArray, after: NDArray) -> NDArray[np.bool_]:
    """Whether object j may be moved: the same agents grasp it before and after and can carry it."""
    bit = 1 << np.arange(len(scenario.agents))
    grasping = len(scenario.regions) + j
    team_before, team_after = (before == grasping) @ bit, (after == grasping) @ bit
    name = scenario.objects[j].name
    strong = np.zeros(1 << len(scenario.agents), dtype=bool)
    for team in np.unique(team_before).tolist():
        members = frozenset(a for i, a in enumerate(scenario.agent_names) if team >> i & 1)
        strong[team] = bool(members) and bool(can_carry(name, members))
    return (team_before == team_after) & strong[team_before]


def _transports_fit(
    fitting: Fitting, options: NDArray, places: NDArray, sources: NDArray, targets: NDArray, moved: NDArray
) -> NDArray[np.bool_]:
    """Whether teams fit as they leave and as they arrive, with their objects as `Content.carried`."""
    fit = np.ones(len(sources), dtype=bool)
    for end in (sources, targets):
        for region in range(len(fitting.scenario.regions)):
            carried = moved & (places[end] == region)
            rows = np.flatnonzero(carried.any(axis=1) & fit)
            fit[rows] = fitting.check(region, options[end[rows]], places[end[rows]], carried[rows])
    return fit


def _sum_of_ways(scenario: Scenario, bodies: NDArray, sources: NDArray, targets: NDArray) -> NDArray:
    """(E,): the scenario's cost, summed over the bodies (S, N + M)."""
    names = scenario.region_names
    table = region_costs(scenario)
    matrix = np.array([[table[start, goal] for goal in names] for start in names])
    total = np.zeros(len(sources))
    for body in bodies.T:
        total += matrix[body[sources], body[targets]]
    return total


def _costs_of(chi: Chi, system: TransitionSystem) -> NDArray[np.float64]:
    states = [system.state(i) for i in range(system.n_states)]
    pairs = zip(system.sources.tolist(), system.targets.tolist(), strict=True)
    costs = np.array([chi(states[before], states[after]) for before, after in pairs], dtype=float)
    wrong = np.flatnonzero(~(np.isfinite(costs) & (costs >= 0)))
    if len(wrong):
        edge = wrong[0]
        before, after = states[system.sources[edge]], states[system.targets[edge]]
        what = f"is {costs[edge]} for the transition from {before} to {after}"
        raise InvalidInputError([Mistake("chi", what, "a cost must be finite and at least zero")])
    return costs
