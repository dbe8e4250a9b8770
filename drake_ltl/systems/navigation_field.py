"""LeafSystem that evaluates the step's navigation function and the Lyapunov function V."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, Context, LeafSystem, OutputPort, ValueProducer

from drake_ltl.errors import ExecutionError
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.field_value import REST, evaluate_field
from drake_ltl.systems.latest_field import LatestField
from drake_ltl.systems.posture_springs import PostureSprings
from drake_ltl.systems.program import MissionProgram
from drake_ltl.systems.signals import STEP_SIGNAL_SIZE
from drake_ltl.systems.step_field import StepField


class NavigationField(LeafSystem):
    """Value and gradient of the navigation function of the step being carried out.

    .. pydrake_system::

        name: NavigationField
        input_ports:
        - step
        - anchor
        - reach_<agent>
        - state_<agent>
        - state_<object>
        output_ports:
        - gradient_<agent>
        - gradient_<object>
        - lyapunov

    `step` is packed by `signals.pack_step`; `anchor` stacks every agent's configuration and every object's
    origin as they were when the phase began: what does not move stands there for phi, so that nothing but the movers
    changes V. `gradient_<agent>` is k dPhi/dq (n_i,), `gradient_<object>` k dPhi/dx (6,) (rotational;
    translational), zero for what does not move; `lyapunov` is V [J].
    """

    def __init__(self, program: MissionProgram, scenario: Scenario, models: MeasuredModels):
        super().__init__()
        self.set_name("navigation_field")
        self._force, self._models = scenario.controller.force, models
        self._latest, self._springs = LatestField(program, scenario, models), PostureSprings(models.agents)
        self._sizes = {name: model.n for name, model in models.agents.items()}
        self._step = self.DeclareVectorInputPort("step", STEP_SIGNAL_SIZE)
        self._anchor = self.DeclareVectorInputPort("anchor", sum(self._sizes.values()) + 3 * len(models.objects))
        self._reach = {name: self.DeclareVectorInputPort(f"reach_{name}", 2 + 2 * n) for name, n in self._sizes.items()}
        self._state = {name: self.DeclareVectorInputPort(f"state_{name}", 2 * n) for name, n in self._sizes.items()}
        self._state |= {name: self.DeclareVectorInputPort(f"state_{name}", 13) for name in models.objects}
        self._value = self.DeclareCacheEntry(
            "value",
            ValueProducer(allocate=Value[object], calc=self._calc_value),
            prerequisites_of_calc={self.all_input_ports_ticket()},
        )
        ticket = {self._value.ticket()}
        self._gradient = {
            name: self.DeclareVectorOutputPort(f"gradient_{name}", n, self._agent_gradient(name, n), ticket)
            for name, n in self._sizes.items()
        }
        self._gradient |= {
            name: self.DeclareVectorOutputPort(f"gradient_{name}", 6, self._object_gradient(name), ticket)
            for name in models.objects
        }
        self._lyapunov = self.DeclareVectorOutputPort("lyapunov", 1, self._calc_lyapunov, ticket)

    def get_step_input_port(self):
        return self._step

    def get_anchor_input_port(self):
        return self._anchor

    def get_reach_input_port(self, agent: str):
        return self._reach[agent]

    def get_state_input_port(self, name: str):
        return self._state[name]

    def get_gradient_output_port(self, name: str) -> OutputPort:
        return self._gradient[name]

    def get_lyapunov_output_port(self) -> OutputPort:
        return self._lyapunov

    def _agent_gradient(self, name: str, n: int):
        def calc(context: Context, output: BasicVector) -> None:
            gradient = self._value.Eval(context)[0].agents.get(name)
            output.SetFromVector(np.zeros(n) if gradient is None else gradient)

        return calc

    def _object_gradient(self, name: str):
        def calc(context: Context, output: BasicVector) -> None:
            gradient = self._value.Eval(context)[0].objects.get(name)
            output.SetFromVector(np.zeros(6) if gradient is None else gradient)

        return calc

    def _calc_lyapunov(self, context: Context, output: BasicVector) -> None:
        output.SetAtIndex(0, self._value.Eval(context)[1])

    def _calc_value(self, context: Context, value) -> None:
        """FieldValue and V."""
        step = self._step.Eval(context)
        reaches = {name: self._reach[name].Eval(context) for name in self._latest.reaching(step)}
        field = self._latest.of(step, self._anchor.Eval(context), reaches)
        if field is None:
            value.set_value((REST, 0.0))
            return
        found = evaluate_field(field, self._force, self._models.agents, self._world(context, field))
        energy = self._kinetic_energy(context, field) + self._posture_energy(context, field)
        value.set_value((found, found.potential + energy))

    def _world(self, context: Context, field: StepField) -> _World:
        sizes = {task.agent: self._sizes[task.agent] for task in field.travels}
        sizes |= {task.object: 7 for task in field.transports}
        positions = {}
        for name, size in sizes.items():
            state = self._state[name].Eval(context)
            if not np.isfinite(state).all():  # a plant's own check would end the process
                raise ExecutionError(f"the state of {name} is not finite at t = {context.get_time():.3f} s")
            positions[name] = state[:size]
        return _World(self._models, positions)

    def _kinetic_energy(self, context: Context, field: StepField) -> float:
        """Of all that moves under phi: travellers, carried objects and the agents that carry them [J]."""
        moving = [task.agent for task in field.travels]
        moving += [name for task in field.transports for name in task.team]
        energy = 0.0
        for name in moving:
            x, n = self._state[name].Eval(context), self._sizes[name]
            energy += self._models.agents[name].energy(x[:n], x[n:])
        for task in field.transports:
            x = self._state[task.object].Eval(context)
            energy += self._models.objects[task.object].kinetic_energy(x[:4], x[7:])
        return energy

    def _posture_energy(self, context: Context, field: StepField) -> float:
        """Of the springs that keep redundant arms in the posture in which they began to carry [J]."""
        carriers = [name for task in field.transports for name in task.team if self._models.agents[name].is_redundant]
        if not carriers:
            return 0.0
        reference, energy = self._latest.snapshot(self._anchor.Eval(context)).q, 0.0
        for name in carriers:
            model, q = self._models.agents[name], self._state[name].Eval(context)[: self._sizes[name]]
            energy += self._springs.of(name, reference[name]).energy(q, model.grasp_jacobian(q))
        return energy


@dataclass(frozen=True)
class _World:
    """Kinematics by each agent's own model."""

    models: MeasuredModels
    positions: Mapping[str, np.ndarray]

    def q(self, name: str) -> np.ndarray:
        return self.positions[name]

    def centre(self, agent: str) -> np.ndarray:
        return self.models.agents[agent].centre(self.positions[agent])

    def centre_jacobian(self, agent: str) -> np.ndarray:
        return self.models.agents[agent].centre_jacobian(self.positions[agent])
