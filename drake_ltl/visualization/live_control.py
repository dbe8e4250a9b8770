"""Pause, single step, slower and faster for a mission that is watched, and what its page says of it."""

from __future__ import annotations

import time
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from pydrake.geometry import Meshcat
from pydrake.systems.analysis import Simulator

from drake_ltl.diagrams.mission_diagram import MissionDiagram
from drake_ltl.execution.recording import NOTHING
from drake_ltl.planning.plan import State
from drake_ltl.planning.plan_json import action_to_json
from drake_ltl.planning.remaining import Pursuit, begins_round
from drake_ltl.scenario.formulas import labels
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.progress import Progress
from drake_ltl.systems.signals import Phase
from drake_ltl.visualization.activity import activities
from drake_ltl.visualization.page_data import standings
from drake_ltl.visualization.words import actions_words, run_heading

PAUSE, STEP, SLOWER, FASTER = "Pause / go on", "Single step", "Slower", "Faster"
BUTTONS = {PAUSE: "Space", STEP: "KeyN", SLOWER: "Minus", FASTER: "Equal"}
"""Names in Meshcat's panel, and their keys."""
RATES = (0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 0.0)
"""Simulated seconds in one of the wall's clock; 0: as many as the computer can."""
PERIOD = 0.1
"""Simulated time between looks at the buttons at a rate of 1 [s]; less at lower rates."""
LAG = 0.5
"""The scene of a page that listens may be this far behind, at higher rates that many times as much [s]."""
SILENCE = 1.0
"""A page that has not asked for so long is not waited for [s]."""
IDLE = 0.03
"""Between looks while it is paused [s]."""


class LiveControl:
    """Obeys the buttons between advances of the Simulator: whoever advances it calls `hold` in between.

    All that the page asks for is in `status`, a dict that is never changed, only replaced.
    """

    def __init__(
        self, meshcat: Meshcat, mission: MissionDiagram, scenario: Scenario, num_steps: int, *, rate: float = 1.0
    ):
        """Adds the buttons to Meshcat's panel.

        Args:
            num_steps: of the run.
            rate: the realtime rate to begin with; 0 for as fast as the computer can.
        """
        self._meshcat, self._mission, self._scenario, self._num_steps = meshcat, mission, scenario, num_steps
        self._rate, self._paused, self._stop_at = rate, False, -1
        self._clicks = dict.fromkeys(BUTTONS, 0)
        self._pursuit, self._read = Pursuit.of(scenario), 0
        self._seen, self._heard = 0.0, -SILENCE  # the simulated time that a page's scene showed, and when it said so
        self._shown = (0.0, time.monotonic(), 0.0)  # simulated time, wall time, rate between looks
        self.status: Mapping[str, Any] = {"time": 0.0, "index": -1, "heading": "Preparing", "lines": [], "goals": []}
        self.status |= {"activities": [], "paused": False, "rate": "", "note": ""}
        for name, key in BUTTONS.items():
            meshcat.AddButton(name, key)

    @property
    def period(self) -> float:
        """Simulated time after which to look again [s]."""
        return PERIOD * min(1.0, self._rate or 1.0)

    def hold(self, simulator: Simulator) -> None:
        """Waits while the mission is paused, and sets its pace."""
        self._wait_for_page(simulator.get_context().get_time())
        progress = self._progress(simulator)
        if 0 <= self._stop_at <= progress.count:
            self._paused, self._stop_at = True, -1
        waited = False
        while True:
            changed = self._obey(progress.count)
            self._measure(simulator)
            self.status = self._make_status(simulator, progress)
            if not self._paused:
                break
            waited = True
            time.sleep(IDLE)
        if waited or changed or simulator.get_target_realtime_rate() != self._rate:
            simulator.set_target_realtime_rate(self._rate)
            simulator.ResetStatistics()  # else it would make up for the time of the pause

    def answer(self, seen: str) -> Mapping[str, Any]:
        """What a page asks for, when it says which simulated time its scene shows [s]."""
        with suppress(ValueError):
            self._seen, self._heard = float(seen), time.monotonic()
        return self.status

    def _wait_for_page(self, now: float) -> None:
        """A page that draws more slowly than the run would fall behind more and more."""
        self._meshcat.Flush()
        lag = LAG * max(1.0, self._rate or RATES[-2])
        while now - self._seen > lag and time.monotonic() - self._heard < SILENCE:
            time.sleep(IDLE)

    def finish(self, simulator: Simulator, reason: str) -> None:
        """The last word of the page: all done, or why the run ended early."""
        heading, lines = ("Stopped", [reason]) if reason else ("All steps done", [])
        status = self._make_status(simulator, self._progress(simulator))
        self.status = {**status, "heading": heading, "lines": lines, "paused": True, "index": -1}

    def _progress(self, simulator: Simulator) -> Progress:
        supervisor = self._mission.supervisor
        return supervisor.GetProgress(supervisor.GetMyContextFromRoot(simulator.get_context()))

    def _obey(self, count: int) -> bool:
        """Whether a button changed the pace."""
        pressed = {name: self._meshcat.GetButtonClicks(name) for name in BUTTONS}
        new = {name: pressed[name] - self._clicks[name] for name in BUTTONS}
        self._clicks = pressed
        if new[PAUSE] % 2:
            self._paused, self._stop_at = not self._paused, -1
        if new[STEP]:
            self._paused, self._stop_at = False, count + 1
        if change := new[FASTER] - new[SLOWER]:
            place = RATES.index(self._rate) if self._rate in RATES else _nearest(self._rate)
            self._rate = RATES[min(max(place + change, 0), len(RATES) - 1)]
        return bool(change)

    def _measure(self, simulator: Simulator) -> None:
        """The rate of about the last half second."""
        now, wall = simulator.get_context().get_time(), time.monotonic()
        then, wall_then, _ = self._shown
        if wall - wall_then > 0.5:
            self._shown = (now, wall, (now - then) / (wall - wall_then))

    def _make_status(self, simulator: Simulator, progress: Progress) -> dict[str, Any]:
        program, supervisor = self._mission.program, self._mission.supervisor
        plan, agents = program.mission.plan, self._scenario.agent_names
        done = progress.phase is Phase.DONE or progress.count >= self._num_steps
        index = program.index(progress.count)
        actions = () if done else tuple(map(action_to_json, program.steps[index].actions))
        modes = [signals.mode for signals in progress.agents]
        grasps = [self._object_of(signals.grasp) for signals in progress.agents]
        doing = activities(agents, self._scenario.object_names, modes, grasps, actions)
        self._follow(progress.count)
        heading = run_heading(progress.count, self._num_steps, len(plan.prefix), len(plan.suffix))
        waiting = supervisor.waiting_for(supervisor.GetMyContextFromRoot(simulator.get_context())) if not done else []
        return {
            "time": simulator.get_context().get_time(),
            "index": -1 if done else index,
            "heading": "All steps done" if done else heading,
            "lines": [] if done else actions_words(actions),
            "goals": standings(self._pursuit.goals),
            "activities": list(doing.items()),
            "paused": self._paused,
            "rate": self._rate_text(),
            "note": f"waiting: {waiting[0]}" if waiting else "",
        }

    def _rate_text(self) -> str:
        wanted = f"\u00d7{self._rate:g}" if self._rate else "max"
        return wanted if self._paused else f"{wanted} ({self._shown[2]:.1f})"

    def _object_of(self, weld: int) -> int:
        if weld == NOTHING:
            return NOTHING
        return self._scenario.object_names.index(self._mission.program.welds[weld].object)

    def _follow(self, count: int) -> None:
        """Reads the letters of all states that the run has reached, as the plan says."""
        plan = self._mission.program.mission.plan
        prefix, suffix, states = len(plan.prefix), len(plan.suffix), plan.states
        while self._read <= count:
            position = self._read
            state = states[position if position < len(states) else prefix + (position - prefix) % suffix]
            letter = _letter(self._scenario, state)
            self._pursuit = self._pursuit.after(letter, begins_round=begins_round(position, prefix, suffix))
            self._read += 1


def _letter(scenario: Scenario, state: State) -> frozenset[str]:
    """The propositions of all members in a state of a plan."""
    members = (*scenario.agent_names, *scenario.object_names)
    shown = (labels(scenario, *pair) for pair in zip(members, (*state.agents, *state.objects), strict=True))
    return frozenset().union(*shown)


def _nearest(rate: float) -> int:
    """Index of the highest of RATES that does not exceed `rate`."""
    return max((place for place, known in enumerate(RATES) if 0.0 < known <= rate), default=0)
