"""The transition system TS of Def. 5, all of it, as arrays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drake_ltl.errors import InvalidInputError, Mistake, SearchLimitError
from drake_ltl.planning.contents import Fitting
from drake_ltl.planning.costs import Chi
from drake_ltl.planning.factors import Box, boxes, n_choices, ways_to_place
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
    sources: NDArray[np.int32]
    """(E,): state in which a transition begins; non-decreasing."""
    targets: NDArray[np.int32]
    """(E,): state in which it ends."""
    costs: NDArray[np.float64]
    """(E,): chi."""
    actions: NDArray[np.int16]
    """(E,): how many agents act in each transition."""
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
        return agent_regions(self.options, self.places, len(self.scenario.regions))

    def state(self, index: int) -> State:
        """The state with a given index, by names."""
        return state_of(self.scenario, self.options[index].tolist(), self.places[index].tolist())

    def index(self, state: State) -> int:
        """The index of a state; -1 if it does not belong to Pi_s.

        Raises:
            InvalidInputError: the state speaks of other members or regions than the scenario.
        """
        digits = digits_of(self.scenario, state)
        if digits is None:
            return -1
        code = _codes([np.array([v]) for v in digits[0] + digits[1]], _bases(self.scenario))
        return int(self.index_of_code[code[0]])

    def without(self, forbidden: frozenset[tuple[State, State]]) -> TransitionSystem:
        """The same without some transitions; pairs that are none are ignored."""
        if not forbidden:
            return self
        pairs = {(self.index(before), self.index(after)) for before, after in forbidden}
        keys = np.array([before * self.n_states + after for before, after in pairs if min(before, after) >= 0])
        return self.keep(~np.isin(self.sources * np.int64(self.n_states) + self.targets, keys))

    def keep(self, kept: NDArray[np.bool_]) -> TransitionSystem:
        """The same with only some transitions, (E,)."""
        rows = np.flatnonzero(kept)
        columns = ("sources", "targets", "costs", "actions")
        return replace(self, **{name: getattr(self, name)[rows] for name in columns})


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
    n_combinations = math.prod(_bases(scenario))
    if n_combinations > MOST_COMBINATIONS:
        raise SearchLimitError(f"{_size(scenario)} have {n_combinations} states, too many to enumerate")
    if n_choices(scenario) > MOST_TRANSITIONS:
        raise SearchLimitError(f"{_size(scenario)} have some {n_choices(scenario)} transitions, too many to enumerate")
    space = _Space.of(scenario, fits)
    pieces = [space.transitions(piece) for box in boxes(scenario, can_carry) for piece in box.pieces()]
    columns = [np.concatenate(column) for column in zip(*pieces, strict=True)]
    sources = columns[0]
    small = sources.astype(np.uint16) if len(space.codes) < 1 << 16 else sources  # numpy sorts short numbers by radix
    order = np.argsort(small, kind="stable")
    sources, targets, costs, actions = (column[order] for column in columns)
    options, places = space.digits
    system = TransitionSystem(
        scenario, options, places, sources, targets, costs, actions, space.index_of_code, len(sources)
    )
    return system if chi is None else replace(system, costs=_costs_of(chi, system))


@dataclass(frozen=True, eq=False)
class _Space:
    """The states, by their codes."""

    scenario: Scenario
    fitting: Fitting
    codes: NDArray[np.int64]
    """(S,)"""
    index_of_code: NDArray[np.int32]
    contents: list[NDArray[np.int64]]
    """For each region its content in each state, (S,)."""

    @classmethod
    def of(cls, scenario: Scenario, fits: Fits) -> _Space:
        """Def. 5 (i): all combinations whose regions' contents fit."""
        fitting, places = Fitting(scenario, fits), ways_to_place(scenario)
        grids = [fitting.grid(region, places) for region in range(len(scenario.regions))]
        codes = np.arange(grids[0].size)
        for region, grid in enumerate(grids):
            codes = codes[fitting.check(region, grid[codes])]
        index_of_code = np.full(grids[0].size, -1, dtype=np.int32)
        index_of_code[codes] = np.arange(len(codes))
        return cls(scenario, fitting, codes, index_of_code, [grid[codes] for grid in grids])

    @property
    def digits(self) -> tuple[NDArray, NDArray]:
        """Options (S, N) and places (S, M)."""
        digits = np.stack(np.unravel_index(self.codes, _bases(self.scenario)), axis=1)
        n_agents = len(self.scenario.agents)
        return digits[:, :n_agents], digits[:, n_agents:]

    def transitions(self, box: Box) -> tuple[NDArray, NDArray, NDArray, NDArray]:
        """Sources, targets, costs and numbers of actions of the transitions of a box."""
        n_regions, n_objects = len(self.scenario.regions), len(self.scenario.objects)
        ends = [self.index_of_code[codes] for codes in box.codes(n_regions + n_objects, n_regions**n_objects)]
        rows = np.flatnonzero((ends[0] >= 0) & (ends[1] >= 0))
        if box.moved and len(rows):
            for end, places in zip(ends, (box.places, box.goals), strict=True):
                rows = rows[self._teams_fit(box, end[rows], places[rows % len(places)])]
        return *(end[rows] for end in ends), *(column[rows] for column in box.total())

    def _teams_fit(self, box: Box, states: NDArray, places: NDArray) -> NDArray[np.bool_]:
        """Whether the teams that move objects fit, with these as `Content.carried`.

        Args:
            box: says which objects are moved.
            states: from which or into which, (n,).
            places: of the objects then, as an index into all ways to place them, (n,).
        """
        where = ways_to_place(self.scenario)[places]
        fit = np.ones(len(states), dtype=bool)
        for region in range(len(self.scenario.regions)):
            added = sum((where[:, j] == region) * self.fitting.carried(j) for j in box.moved)
            rows = np.flatnonzero((added > 0) & fit)
            fit[rows] = self.fitting.check(region, self.contents[region][states[rows]] + added[rows])
        return fit


def state_of(scenario: Scenario, options: list[int], places: list[int]) -> State:
    """A state by names, from the options of agents (N) and the places of objects (M)."""
    regions, objects = scenario.region_names, scenario.object_names
    agents, grasps = [], []
    for option in options:
        held = option - len(regions)
        agents.append(regions[option if held < 0 else places[held]])
        grasps.append(None if held < 0 else objects[held])
    return State(tuple(agents), tuple(regions[k] for k in places), tuple(grasps))


def digits_of(scenario: Scenario, state: State) -> tuple[list[int], list[int]] | None:
    """Options (N) and places (M) of a state; None if an agent is not where the object is that it grasps.

    Raises:
        InvalidInputError: the state speaks of other members or regions than the scenario.
    """
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
        return None  # Def. 5 (i)
    options = [regions[region] if grasp is None else objects[grasp] for region, grasp in pairs]
    return options, [regions[region] for region in state.objects]


def _bases(scenario: Scenario) -> list[int]:
    regions, objects = len(scenario.regions), len(scenario.objects)
    return [regions + objects] * len(scenario.agents) + [regions] * objects


def _codes(columns: Sequence[NDArray], bases: Sequence[int]) -> NDArray[np.int64]:
    """Mixed-radix numbers whose digits are the columns."""
    return np.ravel_multi_index(tuple(columns), tuple(bases))


def agent_regions(options: NDArray, places: NDArray, n_regions: int) -> NDArray[np.int64]:
    """(S, N): region of each agent, from options (S, N) and places (S, M)."""
    grasps = options >= n_regions
    if not grasps.any():
        return options
    held = np.take_along_axis(places, np.where(grasps, options - n_regions, 0), axis=1)
    return np.where(grasps, held, options)


def _size(scenario: Scenario) -> str:
    counts = len(scenario.agents), len(scenario.objects), len(scenario.regions)
    return "{} agents, {} objects and {} regions".format(*counts)


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
