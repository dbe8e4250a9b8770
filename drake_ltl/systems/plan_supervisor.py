"""LeafSystem that carries a plan out: it switches controllers and commands grasps, step by step."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    EventStatus,
    InputPort,
    InputPortIndex,
    LeafSystem,
    OutputPort,
    State,
    ValueProducer,
)

from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.systems.program import StepProgram
from drake_ltl.systems.progress import Measurement, Progress
from drake_ltl.systems.progress_vector import ProgressVector
from drake_ltl.systems.record_signal import record_size, status_signal
from drake_ltl.systems.signals import STEP_SIGNAL_SIZE, Phase, pack_step
from drake_ltl.systems.state_places import StatePlaces
from drake_ltl.systems.supervision import Supervision


class PlanSupervisor(LeafSystem):
    """The hybrid supervisor: plan and rules are immutable attributes, all that changes is discrete state.

    .. pydrake_system::

        name: PlanSupervisor
        input_ports:
        - state
        output_ports:
        - mode_<agent>
        - hold_<agent>
        - reach_<agent>
        - course_<agent>
        - shares_<object>
        - step
        - anchor
        - anchor_<agent>
        - status
        - record
        - progress

    `state` is the plant's whole state (positions and velocities of everything) as it is measured; `mode_<agent>` is the
    selector of the agent's PortSwitch (an InputPortIndex; 1 + signals.Mode); `hold_`, `reach_`, `course_` (of
    differential drives alone) and `shares_` are what the controllers of these names take; `step` is packed by
    `signals.pack_step`; `anchor` all configurations and all objects' origins at the begin of the phase,
    `anchor_<agent>` one of the configurations; `status` (2 + 2 N) is (count, interval, modes, commanded welds),
    `record` the same with `step` and every `reach_<agent>` behind, for a log; `progress` is all of it, a Progress.

    Grasps are welds, and welds are switched by whoever advances the Simulator: whenever the commanded grasps are
    newer than the applied ones, the next look ends AdvanceTo with this system's status. Apply `commanded_grasps`
    to the plant, then call `acknowledge`.
    """

    def __init__(self, places: StatePlaces, supervision: Supervision, models: MeasuredModels, period: float):
        """`places` says what is where in the signal `state`; the supervisor looks every `period` seconds."""
        super().__init__()
        self.set_name("plan_supervisor")
        self.places, self._supervision = places, supervision
        self._sizes = {name: model.n for name, model in models.agents.items()}
        self._drives = [name for name, model in models.agents.items() if not model.has_arm]
        self._objects = list(models.objects)
        self._state = self.DeclareVectorInputPort("state", places.size)
        self._vector = ProgressVector(tuple(self._sizes.values()), len(self._objects))
        self._numbers = self.DeclareDiscreteState(self._vector.size)
        self._applied = self.DeclareNumericParameter(BasicVector([0.0]))
        self._progress = self.DeclareCacheEntry(
            "progress",
            ValueProducer(allocate=Value[object], calc=self._calc_progress),
            prerequisites_of_calc={self.xd_ticket()},
        )
        self._latest: tuple[bytes, Progress | None] = (b"", None)
        self._declare_outputs()
        self.DeclareInitializationDiscreteUpdateEvent(self._initialize)
        # Not a discrete update: the plant's own would then run with what is told now one step later.
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._update)
        self.DeclarePeriodicPublishEvent(period, 0.0, self._hand_over)

    def _declare_outputs(self) -> None:
        state = {self._progress.ticket()}
        self._output: dict[str, OutputPort] = {}

        def declare(name: str, size: int, value: Callable[[Progress], np.ndarray]) -> None:
            latest: tuple[Progress | None, np.ndarray | None] = (None, None)

            def calc(context: Context, output: BasicVector) -> None:
                nonlocal latest
                progress = self.GetProgress(context)
                if latest[0] is not progress:
                    latest = (progress, value(progress))
                output.SetFromVector(latest[1])

            self._output[name] = self.DeclareVectorOutputPort(name, size, calc, state)

        for i, (name, n) in enumerate(self._sizes.items()):
            self._output[f"mode_{name}"] = self.DeclareAbstractOutputPort(
                f"mode_{name}", lambda: AbstractValue.Make(InputPortIndex(1)), self._calc_mode(name), state
            )
            declare(f"hold_{name}", n, lambda progress, i=i: progress.agents[i].hold)
            declare(f"reach_{name}", 2 + 2 * n, lambda progress, i=i: progress.agents[i].reach)
            if name in self._drives:
                declare(f"course_{name}", 1 + n, lambda progress, a=name: self._supervision.course(progress, a))
        for name in self._objects:
            declare(
                f"shares_{name}",
                len(self._sizes),
                lambda progress, o=name: self._supervision.shares(progress, o),
            )
        declare("step", STEP_SIGNAL_SIZE, self._step_signal)
        declare("anchor", sum(self._sizes.values()) + 3 * len(self._objects), lambda progress: progress.anchor)
        starts = np.cumsum([0, *self._sizes.values()])
        for name, start, end in zip(self._sizes, starts, starts[1:], strict=False):
            declare(f"anchor_{name}", int(end - start), lambda progress, a=start, b=end: progress.anchor[a:b])
        declare("status", 2 + 2 * len(self._sizes), status_signal)
        declare("record", record_size(self._sizes.values()), self._record_signal)
        self._output["progress"] = self.DeclareAbstractOutputPort(
            "progress", Value[object], lambda context, output: output.set_value(self.GetProgress(context)), state
        )

    def get_state_input_port(self) -> InputPort:
        return self._state

    def get_mode_output_port(self, agent: str) -> OutputPort:
        return self._output[f"mode_{agent}"]

    def get_hold_output_port(self, agent: str) -> OutputPort:
        return self._output[f"hold_{agent}"]

    def get_reach_output_port(self, agent: str) -> OutputPort:
        return self._output[f"reach_{agent}"]

    def get_course_output_port(self, agent: str) -> OutputPort:
        """Of a differential drive."""
        return self._output[f"course_{agent}"]

    def get_shares_output_port(self, obj: str) -> OutputPort:
        return self._output[f"shares_{obj}"]

    def get_step_output_port(self) -> OutputPort:
        return self._output["step"]

    def get_anchor_output_port(self, agent: str | None = None) -> OutputPort:
        """Of everything, or of one agent."""
        return self._output["anchor" if agent is None else f"anchor_{agent}"]

    def get_status_output_port(self) -> OutputPort:
        return self._output["status"]

    def get_record_output_port(self) -> OutputPort:
        return self._output["record"]

    def get_progress_output_port(self) -> OutputPort:
        return self._output["progress"]

    # For whoever advances the Simulator.

    def commanded_grasps(self, context: Context) -> list[int]:
        """For each agent, the index in `MissionProgram.welds` of the weld that should be active, or NO_GRASP."""
        return [signals.grasp for signals in self.GetProgress(context).agents]

    def grasps_pending(self, context: Context) -> bool:
        """Whether commanded grasps wait to be applied."""
        return self.GetProgress(context).revision != self._applied_revision(context)

    def acknowledge(self, context: Context) -> None:
        """States that the plant's welds are as commanded."""
        context.get_mutable_numeric_parameter(self._applied).SetAtIndex(0, float(self.GetProgress(context).revision))

    def waiting_for(self, context: Context) -> list[str]:
        """What keeps the step from ending, for people."""
        return self._supervision.waiting_for(self.GetProgress(context), self.measured(context))

    def Halt(self, context: Context, unable: frozenset[str]) -> None:
        """Begins the safe mode, in which the `unable` bear no loads."""
        self._put(context, lambda state, now: self._supervision.halt(state, now, unable))

    def SetDown(self, context: Context, agents: Iterable[str], unable: frozenset[str]) -> None:
        """In safe mode: what some agents hold above the floor or askew they lower."""
        self._put(context, lambda state, now: self._supervision.safe_mode.set_down(state, now, agents, unable))

    def LetGo(self, context: Context, agents: Iterable[str]) -> None:
        """In safe mode: some agents open their welds, which waits to be applied, and come away."""
        self._put(context, lambda state, now: self._supervision.safe_mode.let_go(state, now, agents))

    def is_quiet(self, context: Context, but: frozenset[str]) -> bool:
        """In safe mode: whether all but some agents hold at rest."""
        return self._supervision.safe_mode.is_quiet(self.GetProgress(context), self.measured(context), but)

    def step_program(self, context: Context) -> StepProgram:
        """The tasks of the step being carried out."""
        return self._supervision.step(self.GetProgress(context))

    def measured(self, context: Context) -> Measurement:
        """What the supervisor sees now."""
        x, places = self._state.Eval(context), self.places
        q = {name: x[rows] for name, (rows, _) in places.spans.items()}
        qd = {name: x[rows] for name, (_, rows) in places.spans.items()}
        poses = _Poses({name: x[rows] for name, rows in places.pose.items()})
        return Measurement(context.get_time(), q, qd, poses, {name: x[rows] for name, rows in places.velocity.items()})

    def _put(self, context: Context, change: Callable[[Progress, Measurement], Progress]) -> None:
        self.SetProgress(context, change(self.GetProgress(context), self.measured(context)))

    def GetProgress(self, context: Context) -> Progress:
        """The discrete state as Progress."""
        return self._progress.Eval(context)

    def SetProgress(self, context: Context, progress: Progress) -> None:
        """Puts the mission where `progress` says."""
        self._store(progress, context.get_mutable_discrete_state())

    def _calc_progress(self, context: Context, progress) -> None:
        """The same Progress as long as the same numbers stand there: a step of the plant counts as a change."""
        numbers = context.get_discrete_state(self._numbers).value()
        key = numbers.tobytes()
        if self._latest[0] != key:
            self._latest = (key, self._vector.unpack(numbers))
        progress.set_value(self._latest[1])

    # Events.

    def _initialize(self, context: Context, values: DiscreteValues) -> EventStatus:
        self._store(self._supervision.begin(self.measured(context)), values)
        return EventStatus.Succeeded()

    def _update(self, context: Context, state: State) -> EventStatus:
        before = self.GetProgress(context)
        after = self._supervision.advance(before, self._applied_revision(context), self.measured(context))
        if after is before:
            return _NOTHING
        self._store(after, state.get_mutable_discrete_state())
        return EventStatus.Succeeded()

    def _hand_over(self, context: Context) -> EventStatus:
        progress = self.GetProgress(context)
        if progress.phase is Phase.DONE:
            return EventStatus.ReachedTermination(self, "the mission is done")
        if progress.revision != self._applied_revision(context):
            return EventStatus.ReachedTermination(self, "grasps are commanded")
        return _NOTHING

    def _store(self, progress: Progress, values: DiscreteValues) -> None:
        values.set_value(self._numbers, self._vector.pack(progress))

    def _applied_revision(self, context: Context) -> int:
        return int(context.get_numeric_parameter(self._applied).GetAtIndex(0))

    def _calc_mode(self, agent: str):
        index = list(self._sizes).index(agent)

        def calc(context: Context, output: AbstractValue) -> None:
            output.set_value(InputPortIndex(1 + self.GetProgress(context).agents[index].mode))

        return calc

    def _step_signal(self, progress: Progress) -> np.ndarray:
        index = self._supervision.program.index(progress.count)
        return pack_step(index, progress.phase, progress.interval, progress.leg)

    def _record_signal(self, progress: Progress) -> np.ndarray:
        reaches = [signals.reach for signals in progress.agents]
        return np.concatenate([status_signal(progress), self._step_signal(progress), *reaches])


class _Poses(Mapping[str, RigidTransform]):
    """X_WO of objects by their states; formed when it is asked for, which most looks do not."""

    def __init__(self, states: Mapping[str, np.ndarray]):
        self._states = states

    def __getitem__(self, name: str) -> RigidTransform:
        x = self._states[name]
        return RigidTransform(Quaternion(x[:4] / np.linalg.norm(x[:4])), x[4:7])

    def __iter__(self) -> Iterator[str]:
        return iter(self._states)

    def __len__(self) -> int:
        return len(self._states)


_NOTHING = EventStatus.DidNothing()
