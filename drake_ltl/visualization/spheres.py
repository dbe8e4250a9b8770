"""Which bounding spheres stand for which bodies at one instant. Pure functions of the supervisor's status."""

from __future__ import annotations

from collections.abc import Sequence

CARRIES = 3
"""In the supervisor's status and in recordings: modes from this on carry object number mode - CARRIES."""


def team_of(modes: Sequence[int], obj: int) -> list[int]:
    """Indices of the agents that carry object number `obj`."""
    return [agent for agent, mode in enumerate(modes) if mode == CARRIES + obj]


def shown_agents(modes: Sequence[int]) -> list[bool]:
    """An agent's own sphere stands for it unless it is part of a carrying team."""
    return [mode < CARRIES for mode in modes]


def shown_objects(modes: Sequence[int], num_objects: int) -> list[bool]:
    """An object's own sphere stands for it unless it is carried."""
    return [not team_of(modes, obj) for obj in range(num_objects)]


def shown_teams(modes: Sequence[int], num_objects: int) -> list[bool]:
    """The sphere r_{T,j} stands for object j and its team while they carry it."""
    return [bool(team_of(modes, obj)) for obj in range(num_objects)]
