"""What everybody does when a fault has been noticed: brake, come away from what is not held, let go, and wait.

Pure functions on immutable data. Whoever recovers the mission halts it, waits until all rest, lets those let go who
should, and reads off where everything is.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass, replace

import numpy as np
from pydrake.math import RigidTransform

from drake_ltl.dynamics import heading_difference
from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS
from drake_ltl.multibody.measure import STANDOFF_GAP, MeasuredModels
from drake_ltl.multibody.postures import polished
from drake_ltl.systems.hold_controller import TRACKING_FREQUENCY
from drake_ltl.systems.legs import ALL
from drake_ltl.systems.program import GraspTask, ReleaseTask, Weld
from drake_ltl.systems.progress import Measurement, Progress
from drake_ltl.systems.signals import NO_GRASP, Mode, Phase, pack_reach, reach_ends

BACKING_TIME = 3.0
"""A retreat in safe mode takes so long [s]; so does setting down, by some centimetres."""
LIFTED = 5e-4
"""What is held so far above where it would stand is set down before it is let go of [m]: else it would fall ..."""
ASKEW = np.deg2rad(0.05)
"""... as is what is tilted by so much [rad]: else it would tip over, and turn as it does."""
QUIET = 0.02
"""Joints slower than this are at rest [m/s, rad/s]."""


@dataclass(frozen=True)
class SafeMode:
    """The rules of Phase.SAFE."""

    models: MeasuredModels
    welds: tuple[Weld, ...]

    def halt(
        self,
        state: Progress,
        now: Measurement,
        reaches: Mapping[str, GraspTask | ReleaseTask],
        unable: frozenset[str] = frozenset(),
    ) -> Progress:
        """Movers brake and hold; who approaches an object comes away from it, who backs off goes on.

        A hold at q + qd / w, w its frequency, is a brake: the rest of the way decays as exp(-w t), without overshoot.
        Who holds an object goes on to bear its weight, else it would sag and drag over the floor.

        Args:
            reaches: what agents in the mode REACH are about.
            unable: who bears nothing, for its drives fail or its grasp has come open.
        """
        state = replace(state, phase=Phase.SAFE, interval=state.interval + 1, active=ALL, way=(), slow_since=np.inf)
        for index, (name, told) in enumerate(zip(self.models.agents, state.agents, strict=True)):
            task = reaches.get(name)
            if isinstance(task, GraspTask) and told.grasp == NO_GRASP:
                state = self._back_off(state, index, task.weld, now)
            elif told.mode != Mode.HOLD and not isinstance(task, ReleaseTask):
                hold = now.q[name] + now.qd[name] / TRACKING_FREQUENCY
                state = state.with_agent(index, mode=Mode.HOLD, hold=hold)
        return self._shared(state, self.models.agents.keys() - unable)

    def set_down(
        self, state: Progress, now: Measurement, agents: Iterable[str], unable: frozenset[str] = frozenset()
    ) -> Progress:
        """What some agents hold above the floor, as everything is that is carried, or askew, they lower straight to
        where it can stand, and level it; of those the `unable` move along without bearing anything.

        Everybody goes on from where it holds by as much as the object has to move: a load that is not as heavy as it
        is believed to be comes nearer every time.
        """
        wanted = set(agents)
        state = self._shared(state, wanted - unable)
        borne = {self.welds[told.grasp].object for told in state.agents if told.bears > 0.0}
        for index, (name, told) in enumerate(zip(self.models.agents, state.agents, strict=True)):
            if name in wanted and told.grasp != NO_GRASP and self.welds[told.grasp].object in borne:
                X_WO, X_WS = now.X_WO[obj := self.welds[told.grasp].object], self._stands(obj, now)
                if _is_off(X_WO, X_WS):
                    model, q = self.models.agents[name], now.q[name]
                    goal = polished(model, X_WS @ X_WO.inverse() @ model.grasp_pose(q), q)
                    begin = told.hold if told.mode == Mode.HOLD else q
                    reach = pack_reach(now.time, BACKING_TIME, begin, begin + goal - q)
                    state = state.with_agent(index, mode=Mode.REACH, reach=reach)
        return state

    def _stands(self, obj: str, now: Measurement) -> RigidTransform:
        """X_WO of the object where it is, but on the floor and level."""
        model, X_WO = self.models.objects[obj], now.X_WO[obj]
        lying, turned = (R.ToQuaternion().wxyz() for R in (model.R_lying, X_WO.rotation()))
        x, y, _ = X_WO.translation()
        return model.pose(np.array([x, y, model.height]), heading_difference(turned, lying))

    def _shared(self, state: Progress, able: Set[str]) -> Progress:
        """Those of `able` who hold an object bear equal shares of its weight, all others none."""
        holds = {
            name: self.welds[told.grasp].object
            for name, told in zip(self.models.agents, state.agents, strict=True)
            if told.grasp != NO_GRASP and name in able
        }
        holders = Counter(holds.values())
        for index, (name, told) in enumerate(zip(self.models.agents, state.agents, strict=True)):
            bears = 1.0 / holders[holds[name]] if name in holds else 0.0
            state = state if told.bears == bears else state.with_agent(index, bears=bears)
        return state

    def let_go(self, state: Progress, now: Measurement, agents: Iterable[str]) -> Progress:
        """The welds of some agents are commanded to open; they come away from what they held. Who goes on holding does
        so where it is, wherever it had been dragged from."""
        wanted = set(agents)
        for index, (name, told) in enumerate(zip(self.models.agents, state.agents, strict=True)):
            if name in wanted and told.grasp != NO_GRASP:
                state = self._back_off(state, index, self.welds[told.grasp], now)
                state = state.with_agent(index, grasp=NO_GRASP)
            elif told.bears > 0.0 and told.mode == Mode.HOLD:
                state = state.with_agent(index, hold=now.q[name])
        bearing = zip(self.models.agents, state.agents, strict=True)
        state = self._shared(state, {name for name, told in bearing if told.bears > 0.0})
        return replace(state, revision=state.revision + 1)

    def advance(self, state: Progress, now: Measurement) -> Progress:
        """Who has come away holds."""
        for index, (name, told) in enumerate(zip(self.models.agents, state.agents, strict=True)):
            over = told.mode == Mode.REACH and now.time >= told.reach[0] + told.reach[1]
            if over and np.abs(now.qd[name]).max() <= QUIET:
                state = state.with_agent(index, mode=Mode.HOLD, hold=reach_ends(told.reach)[1])
        return state

    def is_quiet(self, state: Progress, now: Measurement, but: frozenset[str]) -> bool:
        """Whether everybody holds and rests, but those out of service, and no object moves."""
        agents = [name for name in self.models.agents if name not in but]
        told = dict(zip(self.models.agents, state.agents, strict=True))
        return all(told[name].mode == Mode.HOLD and np.abs(now.qd[name]).max() <= QUIET for name in agents) and all(
            np.abs(V).max() <= QUIET for V in now.V_WO.values()
        )

    def _back_off(self, state: Progress, index: int, weld: Weld, now: Measurement) -> Progress:
        """Straight against the gripper's direction, as far as the stand-off is from the grasp; farther if need be, for
        the object may not be where it was held."""
        model, geometry, q = self.models.agents[weld.agent], self.models.geometry, now.q[weld.agent]
        (option,) = (g for g in geometry.grasps[weld.agent, weld.object] if g.name == weld.option)
        usual = float(np.linalg.norm(np.subtract(option.p_OoC_standoff, option.p_OoC_grasp)[:2]))
        back = -model.grasp_pose(q).rotation().matrix()[:, 2] * [1.0, 1.0, 0.0]
        back /= np.linalg.norm(back)
        p_OoC = model.centre(q) - now.X_WO[weld.object].translation()
        clear = geometry.agent_radius[weld.agent] + geometry.object_radius[weld.object] + STANDOFF_GAP
        along = float(p_OoC @ back)
        beside = float(p_OoC @ p_OoC) - along**2
        goal = q.copy()
        goal[:NUM_BASE_JOINTS] += max(usual, np.sqrt(max(0.0, clear**2 - beside)) - along) * back[:2]
        return state.with_agent(index, mode=Mode.REACH, reach=pack_reach(now.time, BACKING_TIME, q, goal))


def _is_off(X_WO: RigidTransform, X_WS: RigidTransform) -> bool:
    """Whether an object is above where it stands, or tilted."""
    tilt = X_WO.rotation().InvertAndCompose(X_WS.rotation()).ToAngleAxis().angle()
    return bool(X_WO.translation()[2] - X_WS.translation()[2] > LIFTED or abs(tilt) > ASKEW)
