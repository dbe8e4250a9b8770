"""Forces of carrying teams, on a whole mission."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.integrate import trapezoid

from drake_ltl.visualization.force_figures import force_drawings, team_forces


@pytest.fixture(scope="module")
def forces(case_ii_run, case_ii):
    return team_forces(case_ii_run.recording, case_ii)


@pytest.mark.mission
def test_there_is_one_for_each_transport(forces, case_ii_run):
    steps = case_ii_run.recording.steps
    carried = [(step.number, a["object"]) for step in steps for a in step.actions if a["kind"] == "transport"]
    assert [(force.step, force.object) for force in forces] == carried


@pytest.mark.mission
def test_they_move_all_of_the_team(forces, case_ii_run, models):
    """The impulse of a team's force is the momentum that it and its object gain."""
    recording = case_ii_run.recording
    for force in forces:
        rows = np.searchsorted(recording.time, force.time - 1e-6)

        def momentum(row: int, force=force) -> np.ndarray:
            carriers = [(models.agents[name], recording.q[name], recording.qd[name]) for name in force.share]
            moved = sum(model.mass * model.mass_velocity(q[row], qd[row]) for model, q, qd in carriers)
            return (moved + models.objects[force.object].mass * recording.velocity[force.object][row, 3:])[:2]

        impulse = trapezoid(force.total, force.time, axis=0)
        largest = max(np.linalg.norm(momentum(row)) for row in rows)
        # Between its samples a force that falls as steeply as at the begin of a step is not quite a straight line.
        np.testing.assert_allclose(impulse, momentum(rows[-1]) - momentum(rows[0]), atol=0.1 * largest)


@pytest.mark.mission
def test_members_hand_on_what_the_object_needs(forces, models):
    for force in forces:
        assert sum(force.share.values()) == pytest.approx(1.0)
        handed = sum(force.on_object.values())
        share = np.linalg.norm(handed, axis=1).max() / np.linalg.norm(force.total, axis=1).max()
        assert 0.0 < share < 1.0  # the rest moves the agents themselves


@pytest.mark.mission
def test_they_are_drawn(forces, case_ii_run):
    (drawing,) = force_drawings(case_ii_run.recording, forces)
    figure = Figure()
    drawing.draw(figure)
    upper, lower = figure.axes
    assert len(lower.lines) > len(forces)
    assert any("%" in text.get_text() for text in upper.texts)
