"""Shows a recording in Meshcat again: the same scene, posed as recorded instead of simulated."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, Context, DiagramBuilder, LeafSystem, OutputPort

from drake_ltl.diagrams.quiet import without_half_space_warning
from drake_ltl.diagrams.transport_plant import AddTransportPlant, TransportPlant
from drake_ltl.execution.recording import Recording
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.scenario.model import Scenario
from drake_ltl.visualization.meshcat_scene import AddMissionVisualizer
from drake_ltl.visualization.mission_overlay import PUBLISH_PERIOD


class RecordedStatus(LeafSystem):
    """The supervisor's status as it was recorded, in place of a supervisor.

    .. pydrake_system::

        name: RecordedStatus
        output_ports:
        - status

    `status` (2 + 2 N,): step, phase, then mode and grasp of each agent, at the last sample before the context's time.
    """

    def __init__(self, recording: Recording):
        super().__init__()
        self.set_name("recorded_status")
        self._time = recording.time
        columns = (recording.step[:, None], recording.phase[:, None], recording.mode, recording.grasp)
        self._status = np.hstack(columns).astype(float)
        self._port = self.DeclareVectorOutputPort("status", self._status.shape[1], self._calc, {self.time_ticket()})

    def get_status_output_port(self) -> OutputPort:
        return self._port

    def _calc(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._status[row_at(self._time, context.get_time())])


def PublishReplay(
    recording: Recording,
    scenario: Scenario,
    models: MeasuredModels,
    meshcat: Meshcat,
    *,
    report: Callable[[float], None] | None = None,
) -> None:
    """Publishes every frame of the recording; call `StartPage` before it and the frames become an animation.

    Args:
        scenario: the one the recording was made of.
        models: its models.
        report: told of each frame's share of the whole, in [0, 1].
    """
    builder = DiagramBuilder()
    transport_plant = AddTransportPlant(builder, scenario, models)
    status = builder.AddSystem(RecordedStatus(recording))
    AddMissionVisualizer(
        builder,
        transport_plant=transport_plant,
        supervisor=status,
        scenario=scenario,
        models=models,
        meshcat=meshcat,
    )
    diagram = builder.Build()
    with without_half_space_warning():
        context = diagram.CreateDefaultContext()
    plant_context = transport_plant.plant.GetMyMutableContextFromRoot(context)
    times = frame_times(recording.time)
    for number, time in enumerate(times, start=1):
        context.SetTime(time)
        _pose(transport_plant, plant_context, recording, models, row_at(recording.time, time))
        diagram.ForcedPublish(context)
        if report is not None:
            report(number / len(times))


def frame_times(time: np.ndarray) -> np.ndarray:
    """Multiples of PUBLISH_PERIOD from the first sample to the last, and the last itself [s]."""
    return np.append(np.arange(time[0], time[-1], PUBLISH_PERIOD), time[-1])


def row_at(time: np.ndarray, now: float) -> int:
    """Index of the last sample that is not after `now`; the first before all."""
    return max(0, int(np.searchsorted(time, now + 1e-9, side="right")) - 1)


def _pose(
    transport_plant: TransportPlant, plant_context: Context, recording: Recording, models: MeasuredModels, row: int
) -> None:
    plant = transport_plant.plant
    for name, instance in transport_plant.agents.items():
        plant.SetPositions(plant_context, instance, recording.q[name][row])
    for name, instance in transport_plant.objects.items():
        quaternion, p_WO = np.split(recording.pose[name][row], [4])
        body = plant.GetBodyByName(models.objects[name].body_name, instance)
        X_WO = RigidTransform(Quaternion(quaternion / np.linalg.norm(quaternion)), p_WO)
        plant.SetFreeBodyPose(plant_context, body, X_WO)
