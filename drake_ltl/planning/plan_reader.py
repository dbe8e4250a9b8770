"""Plans read from JSON, whoever wrote it: everything that is wrong is said."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any, TypeVar

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.planning.plan import Action, Plan, State
from drake_ltl.scenario import table as read
from drake_ltl.scenario.model import Scenario
from drake_ltl.scenario.table import Table, UnfitValueError, listing, shown

T = TypeVar("T")

KINDS = ("travel", "grasp", "release", "transport")


def plan_from_json(data: Any, scenario: Scenario) -> Plan:
    """The plan that `plan_to_json` wrote for the same scenario. Whether it is one that holds, `certificate` says.

    Raises:
        InvalidInputError: with every mistake: what is no plan, or names what the scenario has not.
    """
    mistakes: list[Mistake] = []
    table = Table(data, "", mistakes)
    status = table.take("status", read.one_of("optimal", "feasible"))
    if table.sound and "status" in table and status is None:
        raise InvalidInputError(mistakes)  # of no plan everything else is null
    states = _list_of(lambda entry, where: _state(entry, where, scenario, mistakes))
    actions = _list_of(lambda entry, where: _action(entry, where, scenario, mistakes))
    prefix = table.take("prefix", lambda value: states(value, "prefix"))
    suffix = table.take("suffix", lambda value: states(value, "suffix"))
    steps = table.take("steps", lambda value: _list_of(actions)(value, "steps"))
    numbers = {key: table.take(key, _cost) for key in ("prefix_cost", "suffix_cost", "lower_bound")}
    weights = {key: table.take(key, read.not_negative, 1.0) for key in ("alpha", "beta")}
    notes = {key: table.take(key, _map) for key in ("counts", "seconds")}
    if None not in (prefix, suffix, steps) and len(steps) != len(prefix) + len(suffix):
        what = f"there are {len(steps)} for {len(prefix)} states of the prefix and {len(suffix)} of the suffix"
        table.note("steps", what, "write one for each state")
    if suffix == ():
        table.note("suffix", "is empty", "write at least one state")
    if mistakes:
        raise InvalidInputError(mistakes)
    return Plan(prefix=prefix, suffix=suffix, moves=steps, status=status, **numbers, **weights, **notes)


def _list_of(reader: Callable[[Any, str], T]) -> Callable[[Any, str], tuple[T, ...]]:
    """A reader of lists that is told where its list stands, and tells each entry."""

    def read_list(value: Any, where: str) -> tuple[T, ...]:
        if not isinstance(value, list):
            raise UnfitValueError(f"{shown(value)} is not a list", "write [...]")
        return tuple(reader(entry, f"{where}[{index}]") for index, entry in enumerate(value))

    return read_list


def _state(value: Any, where: str, scenario: Scenario, mistakes: list[Mistake]) -> State:
    table = Table(value, where, mistakes)
    agents, objects, regions = scenario.agent_names, scenario.object_names, scenario.region_names
    state = State(
        _of_each(table.table("agents"), agents, regions),
        _of_each(table.table("objects"), objects, regions),
        _of_each(table.table("grasps"), agents, (*objects, None)),
    )
    table.close()
    return state


def _of_each(table: Table, members: tuple[str, ...], choices: Collection[str | None]) -> tuple[Any, ...]:
    values = tuple(table.take(member, _choice(choices)) for member in members)
    table.close()
    return values


def _action(value: Any, where: str, scenario: Scenario, mistakes: list[Mistake]) -> Action:
    table = Table(value, where, mistakes)
    team = _choice(scenario.agent_names)
    action = Action(
        kind=table.take("kind", read.one_of(*KINDS)),
        agents=table.take("agents", lambda value: _list_of(lambda entry, _: team(entry))(value, "agents")),
        start=table.take("from", _choice(scenario.region_names)),
        goal=table.take("to", _choice(scenario.region_names)),
        object=table.take("object", _choice((*scenario.object_names, None))),
    )
    table.close()
    return action


def _choice(choices: Collection[str | None]) -> Callable[[Any], Any]:
    def read_choice(value: Any) -> Any:
        if (isinstance(value, str) or value is None) and value in choices:
            return value
        names = ["null" if choice is None else choice for choice in choices]
        raise UnfitValueError(f"{shown(value)} is unknown", f"write one of {listing(names)}")

    return read_choice


def _cost(value: Any) -> float:
    """As it was written: sums of squares may be larger than any length."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 <= value < 1e300:
        raise UnfitValueError(f"{shown(value)} is not a cost", "write zero or a positive number")
    return value


def _map(value: Any) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise UnfitValueError(f"{shown(value)} is not a map", "write {...}")
    return dict(value)
