"""LeafSystem that says where everybody's bounding sphere is, once for all monitors that ask."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import BasicVector, Context, InputPort, LeafSystem, OutputPort

from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.systems.state_places import StatePlaces


class MemberCentres(LeafSystem):
    """c_i of all agents, then p_WO of all objects.

    .. pydrake_system::

        name: MemberCentres
        input_ports:
        - state
        output_ports:
        - centres

    `state` is the plant's whole state; `centres` (3 (N + M),) [m] in W, member after member.
    """

    def __init__(self, places: StatePlaces, models: MeasuredModels):
        """`places` says what is where in the signal `state`."""
        super().__init__()
        self.set_name("member_centres")
        self._places, self._models = places, models
        self._ends = np.cumsum(places.sizes)[:-1]
        self._origins = np.array(
            [np.arange(pose.start + 4, pose.start + 7) for pose in places.pose.values()], dtype=int
        )
        self._state = self.DeclareVectorInputPort("state", places.size)
        n = 3 * (len(places.agents) + len(places.pose))
        self._centres = self.DeclareVectorOutputPort("centres", n, self._calc, {self._state.ticket()})

    def get_state_input_port(self) -> InputPort:
        return self._state

    def get_centres_output_port(self) -> OutputPort:
        return self._centres

    def _calc(self, context: Context, output: BasicVector) -> None:
        x = self._state.Eval(context)
        q = np.split(x[self._places.q], self._ends)
        output.SetFromVector(centres_of(self._models, q, x[self._origins.ravel()]))


def anchored_centres(models: MeasuredModels, anchor: np.ndarray) -> np.ndarray:
    """The same of all configurations and all objects' origins, stacked, as a Progress has them of the begin of its
    interval."""
    ends = np.cumsum([model.n for model in models.agents.values()])
    *q, origins = np.split(anchor, ends)
    return centres_of(models, q, origins)


def centres_of(models: MeasuredModels, q: list[np.ndarray], origins: np.ndarray) -> np.ndarray:
    """(3 (N + M),) of configurations, agent after agent, and origins (3 M,)."""
    centres = [model.centre(row) for model, row in zip(models.agents.values(), q, strict=True)]
    return np.concatenate([*centres, origins])
