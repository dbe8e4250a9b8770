"""Plans that people write themselves, in the words in which plans are printed."""

from __future__ import annotations

import re
from collections.abc import Sequence

from drake_ltl.errors import CertificateError, InvalidInputError, Mistake
from drake_ltl.planning.actions import apply_actions
from drake_ltl.planning.certificate import check
from drake_ltl.planning.costs import path_cost, sum_of_ways
from drake_ltl.planning.fits import Fits
from drake_ltl.planning.plan import Action, Plan, State
from drake_ltl.scenario.model import Scenario

_NAME = r"([a-z_][a-z0-9_]*)"
_ARROW = "(?:->|\N{RIGHTWARDS ARROW})"
_WAY = rf":\s*{_NAME}\s*{_ARROW}\s*{_NAME}"
_TRAVEL = re.compile(rf"{_NAME}{_WAY}")
_HAND = re.compile(rf"{_NAME}\s+(grasp|release)s\s+{_NAME}")
_CARRY = re.compile(rf"(?:\{{([^}}]*)\}}\s+carry|{_NAME}\s+carries)\s+{_NAME}{_WAY}")
WAIT = "all wait"


def own_plan(scenario: Scenario, start: State, fits: Fits, prefix: Sequence[str], suffix: Sequence[str]) -> Plan:
    """The plan whose steps are written out, checked as the planner checks its own.

    Args:
        start: the first state.
        fits: P_s, the rooms of the regions.
        prefix: a text for each step up to the first state of the suffix: actions as in printed plans, separated by
            semicolons, such as `a1: depot -> dock; a2 grasps crate` or `{a1, a2} carry crate: depot -> dock`;
            or `all wait`.
        suffix: the steps repeated for ever. The last must lead back to where the first begins.

    Raises:
        InvalidInputError: a step cannot be read or is not possible, the suffix does not close, or the plan's word does
            not satisfy the formulas. The message names the first of these.
    """
    if not suffix:
        raise _mistake("suffix", "has no steps", f"write at least {[WAIT]!r}")
    states, moves = [start], []
    for number, text in enumerate((*prefix, *suffix), start=1):
        moves.append(_actions(text, scenario, states[-1], number))
        states.append(apply_actions(scenario, states[-1], moves[-1]))
    loop = len(prefix)
    if states[-1] != states[loop]:
        last, first = _said(states[-1], scenario), _said(states[loop], scenario)
        raise _mistake("suffix", f"ends with {last} but begins with {first}", "write steps that lead back")
    chi = sum_of_ways(scenario)
    plan = Plan(
        prefix=tuple(states[:loop]),
        suffix=tuple(states[loop:-1]),
        moves=tuple(moves),
        prefix_cost=path_cost(states[: loop + 1], chi),
        suffix_cost=path_cost(states[loop:], chi),
        lower_bound=0.0,
        status="feasible",
    )
    try:
        check(plan, scenario, start, fits)
    except CertificateError as error:
        raise _mistake("plan", str(error), "change the steps or the scenario") from error
    return plan


def _actions(text: str, scenario: Scenario, state: State, number: int) -> tuple[Action, ...]:
    if text.strip() in (WAIT, ""):
        return ()
    return tuple(_action(part.strip(), scenario, state, f"step {number}") for part in text.split(";"))


def _action(text: str, scenario: Scenario, state: State, where: str) -> Action:
    place = dict(zip((*scenario.agent_names, *scenario.object_names), state.agents + state.objects, strict=True))
    if found := _TRAVEL.fullmatch(text):
        agent, origin, goal = found.groups()
        action = Action("travel", (agent,), origin, goal)
    elif found := _HAND.fullmatch(text):
        agent, kind, obj = found.groups()
        action = Action(kind, (agent,), place.get(agent, ""), place.get(agent, ""), obj)
    elif found := _CARRY.fullmatch(text):
        team, single, obj, origin, goal = found.groups()
        names = tuple(name.strip() for name in (team or single).split(","))
        action = Action("transport", names, origin, goal, obj)
    else:
        remedy = "write `a: x -> y`, `a grasps o`, `a releases o`, `a carries o: x -> y` or `{a, b} carry o: x -> y`"
        raise _mistake(where, f"{text!r} is no action", remedy)
    _check_names(action, scenario, where)
    for agent in action.agents:
        if place[agent] != action.start:
            raise _mistake(where, f"{agent} is in {place[agent]}, not in {action.start}", f"begin in {place[agent]}")
    return action


def _check_names(action: Action, scenario: Scenario, where: str) -> None:
    objects = () if action.object is None else (action.object,)
    for names, known, kind in (
        (action.agents, scenario.agent_names, "an agent"),
        (objects, scenario.object_names, "an object"),
        ((action.start, action.goal), scenario.region_names, "a region"),
    ):
        for name in names:
            if name and name not in known:
                raise _mistake(where, f"{name!r} is not {kind}", f"write one of {', '.join(known) or 'none'}")


def _said(state: State, scenario: Scenario) -> str:
    names = (*scenario.agent_names, *scenario.object_names)
    places = [f"{name} in {region}" for name, region in zip(names, state.agents + state.objects, strict=True)]
    held = zip(scenario.agent_names, state.grasps, strict=True)
    return ", ".join([*places, *(f"{agent} grasping {obj}" for agent, obj in held if obj)])


def _mistake(where: str, what: str, remedy: str) -> InvalidInputError:
    return InvalidInputError([Mistake(where, what, remedy)])
