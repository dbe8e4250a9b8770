"""LeafSystem that evaluates the navigation function of differential drives: the force on each, and V."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, Context, InputPort, LeafSystem, OutputPort, ValueProducer

from drake_ltl.errors import ExecutionError
from drake_ltl.multibody.differential_drive_model import DifferentialDriveModel
from drake_ltl.navigation.dipolar_field import DipolarField
from drake_ltl.navigation.unicycle import lyapunov


@dataclass(frozen=True)
class DriveFieldValue:
    """All that the field says of one instant."""

    lyapunov: float
    """V = k Phi + sum m v^2 / 2 [J]."""
    forces: np.ndarray
    """f = -k dPhi/dp (N, 2) [N]."""


class DriveField(LeafSystem):
    """f and V of all drives.

    .. pydrake_system::

        name: DriveField
        input_ports:
        - state_<name>
        output_ports:
        - force_<name>
        - lyapunov

    `state_<name>` is the model instance's (q, v), `force_<name>` is f = -k dPhi/dp (2,) [N] in W, `lyapunov` is V [J].
    Evaluating an output raises ExecutionError where spheres meet or a state is not finite.
    """

    def __init__(self, field: DipolarField, models: Mapping[str, DifferentialDriveModel]):
        """`models` in the order of the field's movers, and by their names; ValueError otherwise."""
        super().__init__()
        self.set_name("drive_field")
        if tuple(models) != field.step.movers:
            raise ValueError(f"models of {tuple(models)} for the movers {field.step.movers}")
        self._field, self._models = field, dict(models)
        self._masses = np.array([model.mass for model in models.values()])
        self._state = {
            name: self.DeclareVectorInputPort(f"state_{name}", model.num_states) for name, model in models.items()
        }
        self._value = self.DeclareCacheEntry(
            "value",
            ValueProducer(allocate=Value[object], calc=self._calc_value),
            prerequisites_of_calc={self.all_input_ports_ticket()},
        )
        ticket = {self._value.ticket()}
        self._force = {
            name: self.DeclareVectorOutputPort(f"force_{name}", 2, self._force_of(index), ticket)
            for index, name in enumerate(models)
        }
        self._lyapunov = self.DeclareVectorOutputPort("lyapunov", 1, self._calc_lyapunov, ticket)

    def get_state_input_port(self, name: str) -> InputPort:
        return self._state[name]

    def get_force_output_port(self, name: str) -> OutputPort:
        return self._force[name]

    def get_lyapunov_output_port(self) -> OutputPort:
        return self._lyapunov

    def Evaluate(self, context: Context) -> DriveFieldValue:
        """All of it at once."""
        return self._value.Eval(context)

    def _calc_value(self, context: Context, value) -> None:
        states = [model.planar_state(self._state[name].Eval(context)) for name, model in self._models.items()]
        p, v = np.array([state.p for state in states]), np.array([state.v for state in states])
        for name, good in zip(self._models, np.isfinite(p).all(axis=1) & np.isfinite(v), strict=True):
            if not good:
                raise ExecutionError(f"the state of {name} is not finite at t = {context.get_time():.3f} s")
        potential, forces = self._field.value_and_forces(p)
        if not np.isfinite(forces).all():
            violated = ", ".join(str(label) for label in self._field.violated(p))
            raise ExecutionError(f"in collision: {violated} at t = {context.get_time():.3f} s")
        value.set_value(DriveFieldValue(float(lyapunov(potential, self._masses, v)), forces))

    def _force_of(self, index: int):
        def calc(context: Context, output: BasicVector) -> None:
            output.SetFromVector(self.Evaluate(context).forces[index])

        return calc

    def _calc_lyapunov(self, context: Context, output: BasicVector) -> None:
        output.SetAtIndex(0, self.Evaluate(context).lyapunov)
