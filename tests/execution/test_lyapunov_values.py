"""V worked out from the logs is V as it was while the mission ran."""

from __future__ import annotations

import numpy as np
from drake_ltl.diagrams import MakeMissionDiagram
from pydrake.systems.analysis import Simulator

from drake_ltl.execution.runner import RunMission


def test_it_is_that_of_the_navigation_field(shuttle):
    mission, scenario, models = shuttle
    diagram = MakeMissionDiagram(mission, scenario, models, num_steps=2, separate_controllers=True)
    simulator = Simulator(diagram.diagram, diagram.CreateStartContext())
    recording = RunMission(diagram, num_steps=2, simulator=simulator).recording
    log = diagram.logs["torque"].FindLog(simulator.get_context())
    logged = dict(zip(log.sample_times(), log.data()[-1], strict=True))  # with separate controllers V stands behind
    V = np.array([logged[time] for time in recording.time])
    begins = np.flatnonzero(np.diff(recording.step, prepend=0))  # logged there: V of the step before
    assert len(begins) == 2
    assert V[0] > 0.0
    kept = np.delete(np.arange(len(V)), begins)
    np.testing.assert_allclose(recording.lyapunov[kept], V[kept], rtol=1e-9, atol=1e-12)  # rounding


def test_it_begins_where_the_interval_is_anchored(short_run):
    recording = short_run.recording
    begins = np.flatnonzero(np.diff(recording.step, prepend=-1))[:2]
    assert (recording.lyapunov[begins] > 0.0).all()
    assert (recording.lyapunov[begins] > recording.lyapunov[begins + 1]).all()
