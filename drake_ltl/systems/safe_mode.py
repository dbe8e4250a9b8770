"""What everybody does when a fault has been noticed: brake, come away from what is not held, let go, and wait.

Pure functions on immutable data. Whoever recovers the mission halts it, waits until all rest, lets those let go who
should, and reads off where everything is.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS
from drake_ltl.multibody.measure import STANDOFF_GAP, MeasuredModels
from drake_ltl.multibody.postures import polished
from drake_ltl.systems.hold_controller import TRACKING_FREQUENCY
from drake_ltl.systems.legs import ALL
from drake_ltl.systems.program import GraspTask, ReleaseTask, Weld
from drake_ltl.systems.progress import Measurement, Progress
from drake_ltl.systems.signals import NO_GRASP, Mode, Phase, pack_reach, reach_ends

BACKING_TIME = 3.0
"""A retreat in safe mode takes so long [s]."""
LIFTED = 2e-3
"""What is held so far above where it would stand is set down before it is let go of [m]: else it would fall."""
QUIET = 0.02
"""Joints slower than this are at rest [m/s, rad/s]."""


@dataclass(frozen=True)
class SafeMode:
    """The rules of Phase.SAFE."""

    models: MeasuredModels
    welds: tuple[Weld, ...]

    def halt(self, state: Progress, now: Measurement, reaches: dict[str, GraspTask | ReleaseTask]) -> Progress:
        """Movers brake and hold; who approaches an object comes away from it, who backs off goes on.

        A hold at q + qd / w, w its frequency, is a brake: the rest of the way decays as exp(-w t), without overshoot.

        Args:
            reaches: what agents in the mode REACH are about.
        """
        state = replace(state, phase=Phase.SAFE, interval=state.interval + 1, active=ALL, way=(), slow_since=np.inf)
        for index, (name, told) in enumerate(zip(self.models.agents, state.agents, strict=True)):
            task = reaches.get(name)
            if isinstance(task, GraspTask) and told.grasp == NO_GRASP:
                state = self._back_off(state, index, task.weld, now)
            elif told.mode != Mode.HOLD and not isinstance(task, ReleaseTask):
                hold = now.q[name] + now.qd[name] / TRACKING_FREQUENCY
                state = state.with_agent(index, mode=Mode.HOLD, hold=hold)
        return state

    def set_down(self, state: Progress, now: Measurement, agents: Iterable[str]) -> Progress:
        """What some agents hold above the floor, as everything is that is carried, they lower straight to where it can
        stand."""
        wanted = set(agents)
        for index, (name, told) in enumerate(zip(self.models.agents, state.agents, strict=True)):
            if name in wanted and told.grasp != NO_GRASP:
                weld, q = self.welds[told.grasp], now.q[name]
                obj, p_WO = self.models.objects[weld.object], now.X_WO[weld.object].translation()
                if p_WO[2] - obj.height > LIFTED:
                    model = self.models.agents[name]
                    X_WE = model.grasp_pose(q)
                    X_WE.set_translation(X_WE.translation() - [0.0, 0.0, p_WO[2] - obj.height])
                    goal = polished(model, X_WE, q)
                    state = state.with_agent(index, mode=Mode.REACH, reach=pack_reach(now.time, BACKING_TIME, q, goal))
        return state

    def let_go(self, state: Progress, now: Measurement, agents: Iterable[str]) -> Progress:
        """The welds of some agents are commanded to open; they come away from what they held."""
        wanted = set(agents)
        for index, (name, told) in enumerate(zip(self.models.agents, state.agents, strict=True)):
            if name in wanted and told.grasp != NO_GRASP:
                state = self._back_off(state, index, self.welds[told.grasp], now)
                state = state.with_agent(index, grasp=NO_GRASP)
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
