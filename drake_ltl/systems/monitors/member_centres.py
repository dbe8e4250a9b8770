"""LeafSystem that says where everybody's bounding sphere is, once for all monitors that ask."""

from __future__ import annotations

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.framework import BasicVector, Context, InputPort, LeafSystem, OutputPort

from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.multibody.parsing import CENTRE_FRAME


class MemberCentres(LeafSystem):
    """c_i of all agents, then p_WO of all objects.

    .. pydrake_system::

        name: MemberCentres
        input_ports:
        - body_poses
        output_ports:
        - centres

    `body_poses` are the plant's, which works them out anyway; `centres` (3 (N + M),) [m] in W, member after member.
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        agents: dict[str, ModelInstanceIndex],
        objects: dict[str, ModelInstanceIndex],
    ):
        """`plant` is finalized; objects are free bodies."""
        super().__init__()
        self.set_name("member_centres")
        frames = [plant.GetFrameByName(CENTRE_FRAME, instance) for instance in agents.values()]
        bodies = [plant.get_body(plant.GetBodyIndices(instance)[0]) for instance in objects.values()]
        self._points = [(int(f.body().index()), f.GetFixedPoseInBodyFrame().translation()) for f in frames]
        self._points += [(int(body.index()), np.zeros(3)) for body in bodies]
        self._poses = self.DeclareAbstractInputPort("body_poses", Value[list[RigidTransform]]())
        ticket = {self._poses.ticket()}
        self._centres = self.DeclareVectorOutputPort("centres", 3 * len(self._points), self._calc, ticket)

    def get_body_poses_input_port(self) -> InputPort:
        return self._poses

    def get_centres_output_port(self) -> OutputPort:
        return self._centres

    def _calc(self, context: Context, output: BasicVector) -> None:
        X_W = self._poses.Eval(context)
        output.SetFromVector(np.concatenate([X_W[body] @ p_BC for body, p_BC in self._points]))


def anchored_centres(models: MeasuredModels, anchor: np.ndarray) -> np.ndarray:
    """The same (3 (N + M),) of all configurations and all objects' origins, stacked, as a Progress has them of the
    begin of its interval."""
    ends = np.cumsum([model.n for model in models.agents.values()])
    *q, origins = np.split(anchor, ends)
    centres = [model.centre(row) for model, row in zip(models.agents.values(), q, strict=True)]
    return np.concatenate([*centres, origins])
