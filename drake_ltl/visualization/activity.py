"""What each member is doing, in a few words: from the modes and grasps of the agents at one instant."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from drake_ltl.execution.recording import NOTHING, Recording
from drake_ltl.visualization.spheres import CARRIES

TRAVEL, REACH = 1, 2
"""Modes as recordings have them; beside these 0, hold, and CARRIES + j."""

Changes = list[tuple[float, str]]
"""Since when [s] it is so, and what; in order of time."""


def activities(
    agents: Sequence[str],
    objects: Sequence[str],
    modes: Sequence[int],
    grasps: Sequence[int],
    actions: Iterable[Mapping[str, Any]],
) -> dict[str, str]:
    """Member -> such as `travels to pi3`, `carries o2 to pi4`, `holds o1`, `waits`; of an object who holds it.

    Args:
        modes: of each agent, as recordings have them.
        grasps: index of the object that each agent is welded to, or NOTHING.
        actions: of the step that goes on, as recordings have them.
    """
    own = {agent: action for action in actions for agent in action["agents"]}
    held = [None if index == NOTHING else objects[index] for index in grasps]
    found = {
        agent: _agent(mode, grasped, own.get(agent), objects)
        for agent, mode, grasped in zip(agents, modes, held, strict=True)
    }
    for index, obj in enumerate(objects):
        holders = [agent for agent, grasped in zip(agents, held, strict=True) if grasped == obj]
        carried = any(mode == CARRIES + index for mode in modes)
        found[obj] = _object(holders, carried)
    return found


def activity_changes(recording: Recording) -> dict[str, Changes]:
    """Member -> what it did and since when, over a whole run with at least one sample."""
    now = np.column_stack([recording.step, recording.mode, recording.grasp])
    rows = [0, *(np.flatnonzero(np.any(np.diff(now, axis=0) != 0, axis=1)) + 1).tolist()]
    found: dict[str, Changes] = {name: [] for name in (*recording.agents, *recording.objects)}
    for row in rows:
        number = int(recording.step[row])
        actions = recording.steps[number].actions if number < len(recording.steps) else ()
        said = activities(recording.agents, recording.objects, recording.mode[row], recording.grasp[row], actions)
        for name, text in said.items():
            if not found[name] or found[name][-1][1] != text:
                found[name].append((float(recording.time[row]), text))
    return found


def _agent(mode: int, held: str | None, action: Mapping[str, Any] | None, objects: Sequence[str]) -> str:
    if mode >= CARRIES:
        goal = f" to {action['to']}" if action is not None and action["kind"] == "transport" else ""
        return f"carries {objects[mode - CARRIES]}{goal}"
    if mode == TRAVEL:
        if action is None or action["kind"] == "travel":
            return f"travels to {action['to']}" if action else "travels"
        return f"drives up to {action['object']}"
    if mode == REACH:
        if action is not None and action["kind"] == "release":
            return f"backs off from {action['object']}"
        return f"reaches for {action['object']}" if action else "reaches"
    return f"holds {held}" if held else "waits"


def _object(holders: Sequence[str], carried: bool) -> str:
    if not holders:
        return "free"
    return f"{'carried' if carried else 'held'} by {', '.join(holders)}"
