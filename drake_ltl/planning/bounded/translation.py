"""From a solution of the model to a lasso, and from a lasso to hints and fixed literals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ortools.sat.python import cp_model

from drake_ltl.planning.bounded.lassos import Lassos, Literal
from drake_ltl.planning.bounded.problem import Run
from drake_ltl.planning.plan import State


def run_of(lassos: Lassos, value: Mapping | cp_model.CpSolverSolutionCallback) -> Run:
    """The lasso of a solution; `value(literal)` is 0 or 1."""
    n = sum(value(active) for active in lassos.active)
    states = tuple(_state(lassos, value, t) for t in range(n))
    return states, next(t for t, enters in enumerate(lassos.enters) if value(enters))


def hint(lassos: Lassos, run: Run) -> None:
    """Start from a lasso, if it is short enough."""
    states, loop = run
    if len(states) > lassos.horizon:
        return
    frozen = states + (states[loop],) * (lassos.horizon + 1 - len(states))
    for t, state in enumerate(frozen):
        _hint_state(lassos, t, state)
    for t in range(lassos.horizon):
        lassos.model.add_hint(lassos.active[t], t < len(states))
        lassos.model.add_hint(lassos.enters[t], t == loop)
        lassos.model.add_hint(lassos.inside[t], t >= loop)
        for j, carried in enumerate(lassos.carried[t]):
            lassos.model.add_hint(carried, frozen[t].objects[j] != frozen[t + 1].objects[j])


def around(lassos: Lassos, run: Run, members: set[int], window: range) -> cp_model.CpModel:
    """The model with all but some members fixed to a lasso outside a window of time, and its loop fixed.

    Args:
        run: as long as the horizon.
        members: who is not fixed at all.
        window: positions at which nobody is fixed.
    """
    model = lassos.model.clone()

    def fix(literal: Literal, value: bool) -> None:
        model.add(model.get_bool_var_from_proto_index(literal.index) == int(value))

    states, loop = run
    names, objects = lassos.problem.scenario.region_names, lassos.problem.scenario.object_names
    for t in range(lassos.horizon):
        fix(lassos.active[t], True)
        fix(lassos.enters[t], t == loop)
    for t, state in enumerate((*states, states[loop])):
        if t in window:
            continue
        for m, region in enumerate(state.agents + state.objects):
            if m not in members:
                fix(lassos.at[t][m][names.index(region)], True)
        for i, grasp in enumerate(state.grasps):
            if i not in members:
                for j, name in enumerate(objects):
                    fix(lassos.grasps[t][i][j], grasp == name)
    return model


def _hint_state(lassos: Lassos, t: int, state: State) -> None:
    names, objects = lassos.problem.scenario.region_names, lassos.problem.scenario.object_names
    for m, region in enumerate(state.agents + state.objects):
        for k, name in enumerate(names):
            lassos.model.add_hint(lassos.at[t][m][k], name == region)
    for i, (region, grasp) in enumerate(zip(state.agents, state.grasps, strict=True)):
        for k, name in enumerate(names):
            lassos.model.add_hint(lassos.free[t][i][k], name == region and grasp is None)
            lassos.model.add_hint(lassos.held[t][i][k], name == region and grasp is not None)
        for j, name in enumerate(objects):
            lassos.model.add_hint(lassos.grasps[t][i][j], grasp == name)


def _state(lassos: Lassos, value: Mapping, t: int) -> State:
    scenario, n = lassos.problem.scenario, lassos.problem.n_agents

    def chosen(literals: Sequence[Literal], names: Sequence[str]) -> str | None:
        return next((name for literal, name in zip(literals, names, strict=True) if value(literal)), None)

    regions = tuple(chosen(literals, scenario.region_names) or "" for literals in lassos.at[t])
    grasps = tuple(chosen(literals, scenario.object_names) for literals in lassos.grasps[t])
    return State(regions[:n], regions[n:], grasps)
