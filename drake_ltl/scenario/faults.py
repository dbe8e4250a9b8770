"""The optional block `faults:` of a scenario: what goes wrong while its mission is carried out.

A list; every entry names its kind, what it befalls, and when: at a time, or at the begin of a step of the plan. Only
the simulation reads it. What detects faults does not.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from drake_ltl.scenario import table as read
from drake_ltl.scenario.names import is_name
from drake_ltl.scenario.table import Table, UnfitValueError, did_you_mean, listing, shown

if TYPE_CHECKING:
    from drake_ltl.scenario.model import Agent, Region, TransportObject

LOCKED, LIMP = "locked", "limp"


@dataclass(frozen=True)
class Fault:
    """One thing that goes wrong."""

    kind: str
    """One of `KINDS`."""
    who: str | None = None
    """The agent, the object or the region that it befalls; None if it befalls all measurements."""
    time: float | None = None
    """When [s]; None if at the begin of a step, or from the start."""
    step: int | None = None
    """Number of the step at whose begin it happens, from 1 as people count them; None if at a time."""
    values: Mapping[str, Any] = field(default_factory=dict)
    """What else the kind has, see `KINDS`."""


@dataclass(frozen=True)
class Kind:
    """What entries of one kind look like."""

    member: str | None
    """`agent`, `object`, `region` or None: whom it befalls."""
    entries: Mapping[str, tuple[Callable[[Any], Any], Any]]
    """key -> how it is read, and its default; None if it must be given."""
    timed: bool = True
    """Whether it has a time or a step; else it is there from the start."""


def _share(value: Any) -> float:
    return read.at_most(1.0)(value)


def _impulse(value: Any) -> tuple[float, ...]:
    impulse = read.numbers(2, "[x, y] in N s")(value)
    if not 0.0 < max(map(abs, impulse)) <= LARGEST_IMPULSE:
        raise UnfitValueError(f"{shown(value)} is no push", f"write one of at most {LARGEST_IMPULSE:g} N s, not [0, 0]")
    return impulse


def _at_most_or_zero(largest: float) -> Callable[[Any], float]:
    def reader(value: Any) -> float:
        number = read.not_negative(value)
        if number > largest:
            raise UnfitValueError(f"{shown(value)} is too large", f"write at most {largest:g}")
        return number

    return reader


MOST = 100
"""Entries of the block."""
LARGEST_IMPULSE = 50.0
"""[N s]"""
LARGEST_FRICTION = 1e4
"""[N s/m, N m s/rad]"""
KINDS: Mapping[str, Kind] = {
    "agent_stops": Kind(
        "agent",
        {"how": (read.one_of(LOCKED, LIMP), LOCKED), "friction": (_at_most_or_zero(LARGEST_FRICTION), 0.0)},
    ),
    "torque_limits": Kind("agent", {"factor": (_share, None)}),
    "weld_breaks": Kind("agent", {}),
    "push": Kind("object", {"impulse": (_impulse, None)}),
    "blocked_region": Kind("region", {}),
    "mass": Kind("object", {"factor": (read.at_most(10.0), None)}, timed=False),
    "sensors": Kind(
        None,
        {
            "position_noise": (_at_most_or_zero(0.1), 0.0),
            "velocity_noise": (_at_most_or_zero(1.0), 0.0),
            "delay": (_at_most_or_zero(0.5), 0.0),
        },
        timed=False,
    ),
}
"""Mass and inertia of an object are multiplied with `factor`, as are the torques that an agent's drives can give at
most; friction is what the joints of a limp agent brake with [N s/m, N m s/rad]; nobody may enter a region that is
blocked; noise is the standard deviation of what is measured [m, rad; m/s, rad/s], the delay how old it is [s]."""


def read_faults(
    top: Table, agents: Sequence[Agent], objects: Sequence[TransportObject], regions: Sequence[Region]
) -> tuple[Fault, ...]:
    """All entries of the block; mistakes are noted in the table. Names of members and regions are not looked at if some
    of them cannot be used."""
    entries = top.take("faults", _entries, ()) or ()
    members = {"agent": _usable(agents), "object": _usable(objects), "region": _usable(regions)}
    faults = [_fault(Table(entry, f"faults[{i}]", top.mistakes), members) for i, entry in enumerate(entries)]
    found = tuple(fault for fault in faults if fault is not None)
    without_arm = {agent.name for agent in agents if not agent.has_arm}
    if sum(fault.kind == "sensors" for fault in found) > 1:
        top.note("faults", "`sensors` stands twice", "write all that is wrong with measurements in one entry")
    turned = [obj.name for obj in objects if obj.headings and obj.is_turned]
    if found and turned:
        what = f"a mission with faults cannot turn objects, and {turned[0]} has `headings`"
        top.note("faults", what, "leave out one of the two")
    for i, fault in enumerate(faults):
        if fault is not None and fault.kind == "weld_breaks" and fault.who in without_arm:
            what = f"{fault.who} is a differential drive, and holds nothing that could come loose"
            top.note(f"faults[{i}].agent", what, "name an agent with an arm")
    return found


def _usable(members: Sequence[Agent | TransportObject | Region]) -> list[str]:
    names = [member.name for member in members]
    return names if all(map(is_name, names)) else []


def _entries(value: Any) -> tuple[Any, ...]:
    if not isinstance(value, list):
        remedy = "write indented lines such as `- {kind: agent_stops, agent: a1, time: 10.0}` below it"
        raise UnfitValueError(f"{shown(value)} is not a list", remedy)
    if len(value) > MOST:
        raise UnfitValueError(f"{len(value)} faults are too many", f"write at most {MOST}")
    return tuple({} if entry is None else entry for entry in value)


def _fault(entry: Table, members: Mapping[str, Sequence[str]]) -> Fault | None:
    if not entry.sound:
        return None
    name = entry.take("kind", _kind)
    if name is None:
        return None
    kind = KINDS[name]
    who = entry.take(kind.member, _member(kind.member, members[kind.member])) if kind.member else None
    time = entry.take("time", read.not_negative, None) if kind.timed else None
    step = entry.take("step", read.integer_from(1), None) if kind.timed else None
    if kind.timed and ("time" in entry) == ("step" in entry):
        what = "has both `time` and `step`" if "time" in entry else "has neither `time` nor `step`"
        entry.note(entry.path, what, "write `time: 10.0` in s, or `step: 3` for the begin of the plan's step 3")
    values = {}
    for key, (reader, default) in kind.entries.items():
        values[key] = entry.take(key, reader) if default is None else entry.take(key, reader, default)
    if values.get("friction") and values["how"] == LOCKED:
        entry.note(entry.where("friction"), "is of no use where brakes are on", f"write `how: {LIMP}`, or leave it out")
    if name == "sensors" and None not in values.values() and not any(values.values()):
        entry.note(entry.path, "changes nothing", f"write one of {listing(kind.entries)}")
    entry.close()
    return Fault(name, who, time, step, values)


def _kind(value: Any) -> str:
    if not isinstance(value, str) or value not in KINDS:
        raise UnfitValueError(f"{shown(value)} is no kind of fault", _known(value))
    return value


def _known(value: Any) -> str:
    return f"{did_you_mean(value, KINDS)}known kinds: {listing(KINDS)}"


def _member(kind: str, names: Sequence[str]) -> Callable[[Any], str]:
    def reader(value: Any) -> str:
        name = read.text(value)
        if names and name not in names:
            raise UnfitValueError(
                f"there is no {kind} {shown(name)}", f"{did_you_mean(name, names)}known {kind}s: {listing(names)}"
            )
        return name

    return reader
