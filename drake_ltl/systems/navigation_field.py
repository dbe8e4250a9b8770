"""LeafSystem that evaluates the step's navigation function and the Lyapunov function V."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.common.value import Value
from pydrake.math import RotationMatrix
from pydrake.systems.framework import BasicVector, Context, LeafSystem, OutputPort, ValueProducer

from drake_ltl.dynamics import quaternion_mismatch
from drake_ltl.errors import ExecutionError
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.multibody.object_model import ObjectModel
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.legs import moving_tasks
from drake_ltl.systems.posture_springs import PostureSprings
from drake_ltl.systems.program import MissionProgram
from drake_ltl.systems.signals import STEP_SIGNAL_SIZE, Phase, reach_ends, unpack_step
from drake_ltl.systems.step_field import FieldBuilder, Snapshot, StepField

ROTATION_WEIGHT = 1.0
"""Weight of a carried object's orientation error in gamma [m^2/rad^2]: the paper's gamma_T has none, which leaves
the tilt of a load that one agent carries to itself."""

# Of a carried object the obstacle function G sees x and y, at the height of the goal: a load goes around what is in
# its way. Lifted over it, its team would fold together, in places to postures from which there is no way back down.


@dataclass(frozen=True)
class FieldValue:
    """k Phi and its gradient with respect to all movers, and V."""

    potential: float
    """k Phi [J]."""
    lyapunov: float
    """V = k Phi + kinetic energy of all movers + energy of redundant carriers' springs [J]."""
    agents: Mapping[str, np.ndarray]
    """k dPhi/dq_z (n_z,) of each traveller."""
    objects: Mapping[str, np.ndarray]
    """k dPhi/dx (6,) (rotational; translational) of each carried object."""


REST = FieldValue(0.0, 0.0, {}, {})


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
        self._program, self._scenario, self._models = program, scenario, models
        self._builder, self._springs = FieldBuilder(scenario, models), PostureSprings(models.agents)
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
        self._latest_field: tuple[bytes, StepField | None] = (b"", None)

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

    def Evaluate(self, context: Context) -> FieldValue:
        """All of it at once."""
        return self._value.Eval(context)

    def _agent_gradient(self, name: str, n: int):
        def calc(context: Context, output: BasicVector) -> None:
            gradient = self.Evaluate(context).agents.get(name)
            output.SetFromVector(np.zeros(n) if gradient is None else gradient)

        return calc

    def _object_gradient(self, name: str):
        def calc(context: Context, output: BasicVector) -> None:
            gradient = self.Evaluate(context).objects.get(name)
            output.SetFromVector(np.zeros(6) if gradient is None else gradient)

        return calc

    def _calc_lyapunov(self, context: Context, output: BasicVector) -> None:
        output.SetAtIndex(0, self.Evaluate(context).lyapunov)

    def _calc_value(self, context: Context, value) -> None:
        field = self._field(context)
        value.set_value(REST if field is None else self._evaluate(context, field))

    def _field(self, context: Context) -> StepField | None:
        """phi of this interval: a pure function of the inputs named here, kept for as long as these stay."""
        signal, anchor = self._step.Eval(context), self._anchor.Eval(context)
        step = self._program.steps[unpack_step(signal)[0]]
        reaching = [task.weld.agent for task in (*step.grasps, *step.releases)]
        reaches = {name: self._reach[name].Eval(context) for name in reaching}
        key = b"".join(array.tobytes() for array in (signal, anchor, *reaches.values()))
        if self._latest_field[0] != key:
            self._latest_field = (key, self._build(signal, anchor, reaches))
        return self._latest_field[1]

    def _build(self, signal: np.ndarray, anchor: np.ndarray, reaches: Mapping[str, np.ndarray]) -> StepField | None:
        index, phase, leg = unpack_step(signal)
        step = self._program.steps[index]
        if phase is not Phase.NAVIGATE or not (step.travels or step.transports):
            return None
        ends = {name: reach_ends(reach) for name, reach in reaches.items()}
        return self._builder.field(moving_tasks(step, leg, self._models), self._snapshot(anchor), ends)

    def _snapshot(self, anchor: np.ndarray) -> Snapshot:
        q, p_WO, start = {}, {}, 0
        for name, n in self._sizes.items():
            q[name], start = anchor[start : start + n], start + n
        for name in self._models.objects:
            p_WO[name], start = anchor[start : start + 3], start + 3
        return Snapshot(q, p_WO)

    def _evaluate(self, context: Context, field: StepField) -> FieldValue:
        travels, transports = field.travels, field.transports
        states = {task.agent: self._state[task.agent].Eval(context) for task in travels}
        poses = {task.object: self._state[task.object].Eval(context) for task in transports}
        for name, state in (states | poses).items():
            if not np.isfinite(state).all():  # a plant's own check would end the process
                raise ExecutionError(f"the state of {name} is not finite at t = {context.get_time():.3f} s")
        p = np.empty((len(travels) + len(transports), 3))
        gamma, slopes = 0.0, []
        for row, task in enumerate(travels):
            model, n = self._models.agents[task.agent], self._sizes[task.agent]
            q = states[task.agent][:n]
            p[row] = model.centre(q)
            slope = model.gamma_weights * (q - task.q_goal)
            gamma += slope @ (q - task.q_goal)
            slopes.append(2.0 * slope)
        for row, task in enumerate(transports, start=len(travels)):
            x = poses[task.object]
            p[row] = *x[4:6], task.p_goal[2]
            gamma_R, slope_R = rotation_error(x[:4], task.orientation_goal)
            error = x[4:7] - task.p_goal
            gamma += error @ error + gamma_R
            slopes.append(np.concatenate([slope_R, 2.0 * error]))
        points = field.relations.at(p)
        value, by_gamma, by_p = field.function.value_and_gradient(gamma, points)
        if not np.isfinite(by_gamma):
            violated = ", ".join(str(label) for label in field.function.violated(points))
            raise ExecutionError(f"in collision: {violated}" if violated else f"no gradient at gamma = {gamma!r} m^2")
        k = self._scenario.controller.force
        agents = {
            task.agent: k
            * (
                by_gamma * slopes[row]
                + by_p[row]
                @ self._models.agents[task.agent].centre_jacobian(states[task.agent][: self._sizes[task.agent]])
            )
            for row, task in enumerate(travels)
        }
        objects = {
            task.object: k * (by_gamma * slopes[row] + np.array([0.0, 0.0, 0.0, *by_p[row, :2], 0.0]))
            for row, task in enumerate(transports, start=len(travels))
        }
        lyapunov = k * float(value) + self._kinetic_energy(context, field) + self._posture_energy(context, field)
        return FieldValue(k * float(value), lyapunov, agents, objects)

    def _kinetic_energy(self, context: Context, field: StepField) -> float:
        """Of all that moves under phi: travellers, carried objects and the agents that carry them [J]."""
        moving = [task.agent for task in field.travels]
        moving += [name for task in field.transports for name in task.team]
        energy = 0.0
        for name in moving:
            x, n = self._state[name].Eval(context), self._sizes[name]
            energy += self._models.agents[name].kinetic_energy(x[:n], x[n:])
        for task in field.transports:
            energy += _object_energy(self._models.objects[task.object], self._state[task.object].Eval(context))
        return energy

    def _posture_energy(self, context: Context, field: StepField) -> float:
        """Of the springs that keep redundant arms in the posture in which they began to carry [J]."""
        carriers = [name for task in field.transports for name in task.team if self._models.agents[name].is_redundant]
        if not carriers:
            return 0.0
        reference, energy = self._snapshot(self._anchor.Eval(context)).q, 0.0
        for name in carriers:
            model, q = self._models.agents[name], self._state[name].Eval(context)[: self._sizes[name]]
            energy += self._springs.of(name, reference[name]).energy(q, model.grasp_jacobian(q))
        return energy


def rotation_error(quaternion: np.ndarray, goal: np.ndarray) -> tuple[float, np.ndarray]:
    """3 - tr(R*^T R) = 2 (1 - cos angle) between an orientation and its goal, quaternions (4,), times ROTATION_WEIGHT,
    and its slope (3,) along omega_W."""
    error, slope = quaternion_mismatch(quaternion, goal)
    return ROTATION_WEIGHT * error, ROTATION_WEIGHT * slope


def _object_energy(model: ObjectModel, state: np.ndarray) -> float:
    R = RotationMatrix(Quaternion(state[:4] / np.linalg.norm(state[:4]))).matrix()
    w_O, v = R.T @ state[7:10], state[10:13]
    return 0.5 * float(model.mass * v @ v + w_O @ model.I_OOo_O @ w_O)
