"""From a scenario file to a `Scenario`, or to the list of everything that is wrong with it."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.scenario import checks, formulas, yaml_text
from drake_ltl.scenario import table as read
from drake_ltl.scenario.faults import read_faults
from drake_ltl.scenario.model import (
    Agent,
    ControllerSettings,
    PublishedFits,
    Region,
    Scenario,
    SimulationSettings,
    Tolerances,
    TransportObject,
)
from drake_ltl.scenario.names import is_name
from drake_ltl.scenario.table import Table, UnfitValueError, shown

HEADING_STEP = 2 * math.pi / 3
"""Agents without a heading are spread by this angle [rad]: any two then lock the tilt of what they carry."""
LARGEST_TIME_STEP = 0.02
"""[s]; V was seen to fall up to half of it, at this one it can rise (and the verdict then says so)."""

LARGEST_TOLERANCES = {
    "position": 0.1,
    "speed": 0.5,
    "joint": 0.1,
    "angle": 0.1,
    "weld_position": 0.01,
    "weld_angle": 0.05,
}
"""[m], [m/s], [rad]; beyond these "there", "at rest" and "grasped" mean nothing, and a verdict asks for nothing."""

_CONTROLLER_READERS = {
    "lambda": read.not_negative,
    "shaping": read.one_of("pseudo_huber", "logarithmic", "paper"),
}
Settings = TypeVar("Settings", ControllerSettings, Tolerances, SimulationSettings, PublishedFits)


def load(path: str | os.PathLike[str]) -> Scenario:
    """The scenario in the file at `path`. Relative paths of models start at the file's folder.

    Raises:
        InvalidInputError: with every mistake of the file, each with its key path and what would be right.
        MissingDependencyError: Spot, which reads the formulas, is not installed.
    """
    file = Path(path)
    return loads(yaml_text.read_text(file), base=file.parent, source_name=str(file))


def loads(text: str, *, base: Path | None = None, source_name: str = "scenario", check_models: bool = True) -> Scenario:
    """The scenario that `text` describes; see `load`.

    Args:
        text: YAML.
        base: folder at which relative paths of models start; default: the working folder.
        source_name: what messages call the text; the scenario's name if it gives none.
        check_models: look into the model files; a recording can be judged where they are not.
    """
    data = yaml_text.parse(text, source_name)
    if data is None:
        remedy = "write `regions:`, `agents:` and so on as in the examples"
        raise InvalidInputError([Mistake(source_name, "is empty, or has comments only", remedy)])
    if not isinstance(data, dict):
        remedy = "write `regions:`, `agents:` and so on at the left margin"
        raise InvalidInputError([Mistake(source_name, f"{shown(data)} is not a map", remedy)])
    mistakes: list[Mistake] = []
    scenario = _scenario(Table(data, "", mistakes), checks.ModelFolder(base, check_models), source_name)
    if mistakes:
        raise InvalidInputError(mistakes)
    return dataclasses.replace(scenario, source=text)


def _scenario(top: Table, folder: checks.ModelFolder, source_name: str) -> Scenario:
    """Reads all, notes mistakes in the table; parts with mistakes hold None."""
    name = top.take("name", read.text, Path(source_name).stem)
    workspace = top.table("workspace")
    workspace_radius = workspace.take("radius", read.positive)
    workspace.close()
    regions_table = top.table("regions")
    regions = _regions(regions_table)
    checks.check_regions(regions, workspace_radius, regions_table)

    agents_table, objects_table = top.table("agents"), top.table("objects")
    members = checks.usable_names(*agents_table, *objects_table)
    mistakes_before = len(top.mistakes)
    services = _services(top, members, regions)
    sound = len(top.mistakes) == mistakes_before
    known = _known(services, checks.text_keys(agents_table, objects_table), regions) if sound else {}
    team_radius = top.take("team_radius", read.positive, None)
    region_names = checks.usable_names(*(region.name for region in regions))
    agents = _agents(agents_table, folder, known, region_names)
    objects = _objects(objects_table, folder, known, team_radius, region_names)
    checks.check_members(agents, objects, agents_table, objects_table)
    checks.check_places(agents, regions, agents_table)
    checks.check_places(objects, regions, objects_table)
    scenario = Scenario(
        name=name,
        workspace_radius=workspace_radius,
        regions=regions,
        agents=agents,
        objects=objects,
        spec=top.take("spec", lambda value: formulas.check_global_formula(value, (members and known) or None), "1"),
        services=services,
        cost=top.take("cost", read.one_of("squared_distance", "distance"), "squared_distance"),
        fits=_fits(top, agents),
        seed=top.take("seed", read.integer_from(0), 0),
        team_radius=team_radius,
        controller=_settings(top.table("controller"), ControllerSettings, _CONTROLLER_READERS),
        tolerances=_settings(
            top.table("tolerances"), Tolerances, {key: read.at_most(most) for key, most in LARGEST_TOLERANCES.items()}
        ),
        simulation=_settings(
            top.table("simulation"), SimulationSettings, {"time_step": read.at_most(LARGEST_TIME_STEP)}
        ),
        faults=read_faults(top, agents, objects, regions),
    )
    top.close()
    return scenario


def _regions(table: Table) -> tuple[Region, ...]:
    regions = []
    for name, entry in table.tables():
        checks.note_name(name, table)
        centre = entry.take("centre", read.numbers(3, "[x, y, z] in m"))
        regions.append(Region(name, centre, entry.take("radius", read.positive)))
        entry.close()
    return tuple(regions)


def _agents(
    table: Table, folder: checks.ModelFolder, known: dict[Any, tuple[str, ...]], regions: list[str]
) -> tuple[Agent, ...]:
    agents = []
    for index, (name, entry) in enumerate(table.tables()):
        checks.note_name(name, table)
        file = entry.take("model", read.text)
        joints = entry.take("joints", read.number_list, None)
        model, has_arm = checks.check_agent_model(file, folder, joints, entry)
        agents.append(
            Agent(
                name=name,
                model=model,
                position=entry.take("position", read.numbers(2, "[x, y] in m")),
                heading=entry.take("heading", read.number, index * HEADING_STEP),
                power=checks.take_power(has_arm, folder, entry),
                spec=_spec(entry, known.get(name)),
                joints=joints,
                radius=entry.take("radius", read.positive, None),
                has_arm=has_arm is not False,
                headings=_arrival_headings(has_arm, entry, regions),
            )
        )
        entry.close()
    return tuple(agents)


def _objects(
    table: Table,
    folder: checks.ModelFolder,
    known: dict[Any, tuple[str, ...]],
    team_radius: float | None,
    regions: list[str],
) -> tuple[TransportObject, ...]:
    objects = []
    for name, entry in table.tables():
        checks.note_name(name, table)
        objects.append(
            TransportObject(
                name=name,
                model=checks.check_object_model(entry.take("model", read.text), folder, entry),
                position=entry.take("position", read.numbers(2, "[x, y] in m")),
                power_needed=entry.take("power_needed", read.positive, 1.0),
                spec=_spec(entry, known.get(name)),
                radius=entry.take("radius", read.positive, None),
                team_radius=entry.take("team_radius", read.positive, team_radius),
                orientation=_orientation(entry),
                headings=_headings(entry, regions),
            )
        )
        entry.close()
    return tuple(objects)


def _orientation(entry: Table) -> tuple[float, float, float]:
    """Roll, pitch and yaw: `heading` for what stands upright, or all three as `orientation`."""
    heading = entry.take("heading", read.number, 0.0)
    orientation = entry.take("orientation", read.numbers(3, "[roll, pitch, yaw] in rad"), None)
    if "orientation" not in entry:
        return 0.0, 0.0, 0.0 if heading is None else heading
    if "heading" in entry:
        remedy = "write one of them: the yaw is part of an orientation"
        entry.note(entry.where("heading"), "stands beside `orientation`", remedy)
    return orientation or (0.0, 0.0, 0.0)


def _headings(entry: Table, regions: list[str]) -> dict[str, float]:
    """region -> heading with which an object is set down there, or a drive arrives."""
    table = entry.table("headings")
    headings = {}
    for region in table:
        if regions and region not in regions:
            checks.note_unknown(region, regions, "region", table)
        headings[region] = table.take(region, read.number)
    return headings


def _arrival_headings(has_arm: bool | None, entry: Table, regions: list[str]) -> dict[str, float]:
    """Of a differential drive."""
    headings = _headings(entry, regions)
    if has_arm and headings:
        what = "only differential drives arrive with a heading; other agents do not turn to travel"
        entry.note(entry.where("headings"), what, "leave the key out")
    return headings


def _known(services: Any, members: list[str], regions: tuple[Region, ...]) -> dict[str, tuple[str, ...]]:
    """The propositions of each member with a usable name, if the regions have: one mistake is to be reported once."""
    names = checks.usable_names(*(region.name for region in regions))
    named = [member for member in members if is_name(member)]
    return {member: formulas.own_propositions(services, member, names) for member in named if names}


def _spec(entry: Table, known: tuple[str, ...] | None) -> str:
    return entry.take("spec", lambda value: formulas.check_member_formula(value, known), "1")


def _services(top: Table, members: list[str], regions: tuple[Region, ...]) -> dict[str, dict[str, tuple[str, ...]]]:
    """L_i and L_j^O: member -> region -> names. `members` is empty if some of their names cannot be used."""
    table = top.table("services")
    names = checks.usable_names(*(region.name for region in regions))
    services: dict[str, dict[str, tuple[str, ...]]] = {}
    for member, entry in table.tables():
        if members and member not in members:
            checks.note_unknown(member, members, "member", table)
        services[member] = {}
        for region in entry:
            if names and region not in names:
                checks.note_unknown(region, names, "region", entry)
            services[member][region] = entry.take(region, checks.name_list) or ()
    return services


def _fits(top: Table, agents: Sequence[Agent]) -> PublishedFits | None:
    """None for `geometric`, which is the default."""
    if isinstance(top.peek("fits"), dict):
        if drives := [agent.name for agent in agents if not agent.has_arm]:
            what = f"the published counts take every agent for one that grasps, and {drives[0]} has no arm"
            top.note("fits", what, "write geometric")
        return _settings(top.table("fits"), PublishedFits)

    def geometric(value: Any) -> None:
        if value != "geometric":
            raise UnfitValueError(
                f"{shown(value)} is unknown",
                "write geometric, or {agent: 1.25, grasping: 2.5, object: 0.5, capacity: 5.75}",
            )

    return top.take("fits", geometric, None)


def _settings(table: Table, kind: type[Settings], readers: dict[str, Any] | None = None) -> Settings:
    """A dataclass of numbers from the keys of its fields: positive ones, unless `readers` says otherwise."""
    values = {}
    for field in dataclasses.fields(kind):
        key = field.name.rstrip("_")
        default = {} if field.default is dataclasses.MISSING else {"default": field.default}
        usual = read.integer_from(1) if field.type == "int" else read.positive
        values[field.name] = table.take(key, (readers or {}).get(key, usual), **default)
    table.close()
    return kind(**values)
