"""What can be refused before a mission is run."""

from __future__ import annotations

import numpy as np

from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.planning.mission import Layout
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.legs import Moving
from drake_ltl.systems.program import MissionProgram, start_configuration
from drake_ltl.systems.step_field import FieldBuilder, Snapshot


def check_fields(program: MissionProgram, scenario: Scenario, models: MeasuredModels) -> None:
    """Builds the navigation function of every step once, as the mission is placed.

    Raises:
        InvalidInputError: the controller's settings do not allow one (lambda > 0 with too many relations), or a
            goal touches something.
    """
    builder = FieldBuilder(scenario, models)
    for step, placed in zip(program.steps, program.mission.steps, strict=True):
        if step.travels or step.transports:
            builder.field(Moving(step.travels, step.transports), snapshot(placed.before, models), {})


def snapshot(layout: Layout, models: MeasuredModels) -> Snapshot:
    """The layout in joint coordinates."""
    p_WO = {name: np.asarray(p, dtype=float) for name, p in layout.objects.items()}
    q = {}
    for name, stand in layout.agents.items():
        if stand.grasp is None:
            q[name] = start_configuration(stand, name, models)
            continue
        obj, option = stand.grasp
        q[name] = models.grasping(name, obj, option, layout.headings[obj]).copy()
        q[name][:NUM_BASE_JOINTS] += p_WO[obj][:2]
    return Snapshot(q, p_WO)
