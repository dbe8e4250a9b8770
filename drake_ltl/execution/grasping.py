"""Switches the plant's welds as the supervisor commands. Only between AdvanceTo calls."""

from __future__ import annotations

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context

from drake_ltl.diagrams.mission_diagram import MissionDiagram
from drake_ltl.errors import GraspError
from drake_ltl.multibody.parsing import GRASP_FRAME
from drake_ltl.multibody.postures import pose_error


def ApplyGrasps(mission: MissionDiagram, root_context: Context, broken: frozenset[int] = frozenset()) -> None:
    """Makes exactly the commanded welds active, but those that are broken, and acknowledges them.

    Raises:
        GraspError: a gripper is farther from its grasp frame than the scenario's tolerances allow. A weld closes
            its gap within two time steps, however wide: refused before anything is switched.
    """
    plant = mission.transport_plant.plant
    plant_context = plant.GetMyMutableContextFromRoot(root_context)
    supervisor_context = mission.supervisor.GetMyMutableContextFromRoot(root_context)
    commanded = set(mission.supervisor.commanded_grasps(supervisor_context)) - broken
    active = [plant.GetConstraintActiveStatus(plant_context, i) for i in mission.transport_plant.weld_ids]
    for index, is_active in enumerate(active):
        if index in commanded and not is_active:
            _check_alignment(mission, plant_context, index)
    for index, weld_id in enumerate(mission.transport_plant.weld_ids):
        plant.SetConstraintActiveStatus(plant_context, weld_id, index in commanded)
    mission.supervisor.acknowledge(supervisor_context)


def _check_alignment(mission: MissionDiagram, plant_context: Context, index: int) -> None:
    parts, weld = mission.transport_plant, mission.transport_plant.welds[index]
    (configuration,) = (g for g in mission.models.grasps[weld.agent, weld.object] if g.name == weld.option)
    frame_E = parts.plant.GetFrameByName(GRASP_FRAME, parts.agents[weld.agent])
    body_O = parts.plant.GetBodyByName(mission.models.objects[weld.object].body_name, parts.objects[weld.object])
    X_WG = body_O.EvalPoseInWorld(plant_context) @ RigidTransform(configuration.X_OE)
    error = pose_error(frame_E.CalcPoseInWorld(plant_context), X_WG)
    angle, gap = float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))
    tolerances = mission.scenario.tolerances
    if gap > tolerances.weld_position or angle > tolerances.weld_angle:
        raise GraspError(
            f"{weld.agent} cannot be welded to {weld.object}: its gripper is {1e3 * gap:.2f} mm and "
            f"{np.rad2deg(angle):.3f} degrees off, at most {1e3 * tolerances.weld_position:.2f} mm and "
            f"{np.rad2deg(tolerances.weld_angle):.3f} degrees are allowed"
        )
