"""Where a run stands when its mission is planned again: read off what is measured and what was recorded."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drake_ltl.execution.joined import Part, joined
from drake_ltl.execution.recording import Recording
from drake_ltl.faults.legs import Bodies
from drake_ltl.faults.losses import Losses
from drake_ltl.planning.replanning import BETWEEN, Situation, Whereabouts
from drake_ltl.scenario.model import Scenario
from drake_ltl.scenario.starts import AgentStart, ObjectStart

TURNED = np.deg2rad(0.5)
"""An object that is turned by more is grasped by nobody [rad]; by who cannot turn if it is turned by more than welds
may be off."""


def situation(bodies: Bodies, losses: Losses) -> Situation:
    """Where everything is, and what can no longer be moved or grasp."""
    models = bodies.models
    outside = {name for name in models.objects if bodies.region(name) is None}
    can_turn = all(model.yaw_direction for model in models.agents.values() if model.has_arm)
    most = TURNED if can_turn else min(TURNED, bodies.scenario.tolerances.weld_angle)
    turned = {name for name in models.objects if _turn(bodies, name) > most}
    return Situation(
        agents={
            name: AgentStart(bodies.region(name) or BETWEEN, bodies.posture(name), _vector(bodies.centre(name)))
            for name in models.agents
        },
        objects={
            name: ObjectStart(bodies.region(name) or BETWEEN, _vector(bodies.centre(name))) for name in models.objects
        },
        stuck=frozenset(losses.agents | losses.objects | turned | outside),
        cannot_grasp=losses.grippers,
        blocked=losses.regions,
    )


def _turn(bodies: Bodies, obj: str) -> float:
    """How far the object is from the orientation with which the mission began [rad]."""
    model = bodies.models.objects[obj]
    R_nominal = model.pose(np.zeros(3), model.object.heading).rotation()
    difference = R_nominal.inverse() @ bodies.now.X_WO[obj].rotation()
    return abs(difference.ToAngleAxis().angle())


def whereabouts(scenario: Scenario, parts: Sequence[Part]) -> list[Whereabouts]:
    """Where everything was when each step so far began."""
    recording = joined(parts, "under way")
    firsts = np.searchsorted(recording.step, np.arange(len(recording.steps)))
    return [_regions(recording, scenario, int(sample)) for sample in firsts]


def _regions(recording: Recording, scenario: Scenario, sample: int) -> Whereabouts:
    spheres = {name: (recording.centre[name][sample], recording.agent_radius[name]) for name in recording.agents}
    spheres |= {name: (recording.pose[name][sample, 4:], recording.object_radius[name]) for name in recording.objects}
    found: dict[str, str | None] = dict.fromkeys(spheres)
    for name, (centre, radius) in spheres.items():
        for region in scenario.regions:
            if np.linalg.norm(centre - np.array(region.centre)) + radius <= region.radius + 1e-9:
                found[name] = region.name
    return found


def _vector(p: np.ndarray) -> tuple[float, float, float]:
    x, y, z = map(float, p)
    return x, y, z
