"""What is wrong although every single value can be read: names, regions and models against each other."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drake_ltl.scenario import model_access, model_files
from drake_ltl.scenario import table as read
from drake_ltl.scenario.model import Agent, Region, TransportObject
from drake_ltl.scenario.names import check_name, is_name
from drake_ltl.scenario.table import Table, UnfitValueError, did_you_mean, listing, shown

SHIPPED = {"agents": ("agents", "bases"), "objects": ("objects",)}
"""Folders of models for members of each kind."""
ROUNDING = 1e-9
"""Overlaps below this [m] are rounding of decimal numbers."""


def note_name(name: Any, table: Table) -> None:
    """Notes a name that cannot stand in a formula."""
    table.attempt(name, lambda: check_name(name))


def note_unknown(name: Any, known: Iterable[Any], kind: str, table: Table) -> None:
    """Notes that nothing of that `kind` is called `name`."""
    remedy = f"{did_you_mean(name, known)}known {kind}s: {listing(known)}"
    table.note(table.where(name), f"there is no {kind} {shown(name)}", remedy)


def name_list(value: Any) -> tuple[str, ...]:
    """Names of services, each once."""
    if not isinstance(value, list):
        raise UnfitValueError(f"{shown(value)} is not a list of names", "write [charge, dock] or []")
    names = tuple(check_name(entry) for entry in value)
    if len(set(names)) < len(names):
        raise UnfitValueError(f"{shown(value)} names a service twice", "write each once")
    return names


def usable_names(*names: Any) -> list[str]:
    """The names, or none of them if one cannot be used: what refers to it would be called unknown as well."""
    return list(names) if all(map(is_name, names)) else []


def text_keys(*tables: Table) -> list[str]:
    """All keys that are text, each once."""
    return list(dict.fromkeys(key for table in tables for key in table if isinstance(key, str)))


def check_regions(regions: tuple[Region, ...], workspace_radius: float | None, table: Table) -> None:
    """Notes regions that overlap or leave the workspace. Parts that could not be read are None."""
    if not regions and table.sound:
        table.note(table.path, "there is no region", "write at least one, as `pi1: {centre: [0, 0, 0], radius: 3.5}`")
    sound = [region for region in regions if region.centre is not None and region.radius is not None]
    for region in sound:
        excess = math.hypot(*region.centre) + region.radius - (workspace_radius or math.inf)
        if excess > ROUNDING:
            what = f"the region reaches {excess:.4g} m beyond the workspace of radius {workspace_radius:g}"
            table.note(table.where(region.name), what, "move it towards the origin, or let it be smaller")
    for index, second in enumerate(sound):
        overlaps = ((f.radius + second.radius - math.dist(f.centre, second.centre), f) for f in sound[:index])
        overlap, first = next(((o, f) for o, f in overlaps if o > ROUNDING), (0.0, second))
        if overlap:
            what = f"the region overlaps region {shown(first.name)} by {overlap:.4g} m"
            table.note(table.where(second.name), what, "move them apart, or let them be smaller")


def check_members(
    agents: tuple[Agent, ...], objects: tuple[TransportObject, ...], agents_table: Table, objects_table: Table
) -> None:
    """Notes a scenario without agents, names used twice and teams smaller than what they carry."""
    if not agents and agents_table.sound:
        agents_table.note(agents_table.path, "there is no agent", "write at least one")
    agent_names = {agent.name for agent in agents}
    for obj in objects:
        where = objects_table.where(obj.name)
        if obj.name in agent_names:
            objects_table.note(where, f"an agent is called {shown(obj.name)} as well", "choose another name")
        if obj.radius is not None and obj.team_radius is not None and obj.team_radius < obj.radius:
            what = f"team_radius {obj.team_radius:g} is less than the object's radius {obj.radius:g}"
            objects_table.note(where, what, "write one that covers the object and whoever grasps it")


def check_places(members: Iterable[Agent | TransportObject], regions: tuple[Region, ...], table: Table) -> None:
    """Notes members whose origin lies beyond every region, seen from above: their spheres, which hold it, do as well.

    What is nearer than that takes the models to find out (`starts.check_starts`). Parts that could not be read are
    None; among regions of which one could not be, nobody is said to be in none.
    """
    if not regions or any(region.centre is None or region.radius is None for region in regions):
        return
    for member in members:
        if member.position is None:
            continue
        beyond = {region.name: math.dist(member.position, region.centre[:2]) - region.radius for region in regions}
        nearest = min(beyond, key=beyond.__getitem__)
        if beyond[nearest] > ROUNDING:
            what = f"{shown(list(member.position))} lies in no region: it is {beyond[nearest]:.4g} m beyond {nearest}"
            where = f"{table.where(member.name)}.position"
            table.note(where, what, f"move it towards the centre of {nearest}")


@dataclass(frozen=True)
class ModelFolder:
    """Where relative paths of models start, and whether the files are looked into."""

    path: Path | None
    look: bool = True


def check_agent_model(
    uri: str | None, folder: ModelFolder, joints: tuple[float, ...] | None, entry: Table
) -> tuple[str, bool | None]:
    """The model's URI or absolute path, after a look into its file, and whether it has an arm, which a differential
    drive has not (None if that is not known); `joints` are the arm's at the start."""
    path = _existing(uri, folder, "agents", entry)
    if path is None:
        return uri or "", None
    remedy = (
        "an agent is a URDF whose first two movable joints are the prismatic x and y of its base, "
        "followed by at least two joints of its arm; or a differential drive, of which nothing moves but its wheels, "
        "joints left and right"
    )
    count = _look_into(lambda: model_files.check_agent(path), remedy, entry)
    if count == 0 and joints is not None:
        entry.note(entry.where("joints"), f"{path.name} has no arm", "leave the key out")
    elif count is not None and joints is not None and len(joints) != count:
        what = f"{shown(list(joints))} has {len(joints)} entries, {path.name} has {count} arm joints"
        entry.note(entry.where("joints"), what, f"write {count} angles, or leave the key out")
    return _stored(uri, path), None if count is None else count > 0


def take_power(has_arm: bool | None, folder: ModelFolder, entry: Table) -> float:
    """zeta_i: positive, but 0 of an agent that cannot grasp."""
    may_be_zero = has_arm is False or not folder.look
    reader = read.not_negative if may_be_zero else read.positive
    power = entry.take("power", reader, 0.0 if has_arm is False else 1.0)
    if has_arm is False and power:
        what = f"{shown(power)} is of no use: the agent stands on two driven wheels and has no arm"
        entry.note(entry.where("power"), what, "write 0, or leave the key out")
    return power


def check_object_model(uri: str | None, folder: ModelFolder, entry: Table) -> str:
    """The model's URI or absolute path, after a look into its file."""
    path = _existing(uri, folder, "objects", entry)
    if path is None:
        return uri or ""
    _look_into(lambda: model_files.check_object(path), "an object is an SDFormat file or a URDF", entry)
    return _stored(uri, path)


def _existing(uri: str | None, folder: ModelFolder, kind: str, entry: Table) -> Path | None:
    if uri is None or not folder.look:
        return None
    shipped = [name for inside in SHIPPED[kind] for name in model_files.shipped(inside)]
    meant = did_you_mean(Path(uri).name, [Path(name).name for name in shipped])
    remedy = f"{meant}write the path of a file, or one of: {listing(shipped)}"

    def find() -> Path:
        try:
            path = model_files.resolve(uri, folder.path)
            model_access.check_access(path, folder.path)
            exists = path.is_file()
            if exists:
                model_access.check_references(path, folder.path)
        except model_access.NotAllowedError as error:
            raise UnfitValueError(error.what, error.remedy) from error
        except (ValueError, OSError, RuntimeError) as error:  # a home folder that nobody has, a name too long
            reason = getattr(error, "strerror", None) or shown(str(error))
            raise UnfitValueError(f"{shown(uri)} cannot be found ({reason})", remedy) from error
        if not exists:
            raise UnfitValueError(f"{shown(uri)} is no file{_looked_for(uri, path)}", remedy)
        return path

    return entry.attempt("model", find)


def _looked_for(uri: str, path: Path) -> str:
    """Where, if the name does not say it."""
    return "" if "://" in uri or str(path) == uri else f" (looked for as {path.absolute()})"


def _look_into(look: Any, remedy: str, entry: Table) -> Any:
    def action() -> Any:
        try:
            return look()
        except (ValueError, OSError) as error:
            raise UnfitValueError(" ".join(str(error).split()), remedy) from error

    return entry.attempt("model", action)


def _stored(uri: str, path: Path) -> str:
    """Paths become absolute, so that a scenario means the same from any folder."""
    return uri if uri.startswith("package://") else str(path.resolve())
