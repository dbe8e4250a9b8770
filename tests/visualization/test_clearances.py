import numpy as np
import pytest

from drake_ltl.visualization.clearances import clearance_curves


@pytest.fixture
def curves(recording, scenario):
    """(step, kind) -> curve; the recording has samples of 4 steps and no rest."""
    starts = [step.start for step in recording.steps]
    return {
        (int(np.searchsorted(starts, curve.time[0], side="right")) - 1, curve.kind): curve
        for curve in clearance_curves(recording, scenario)
    }


def rows(recording, step):
    """A step's samples and the one that shows its end."""
    own = np.flatnonzero(recording.step == step)
    return np.append(own, own[-1] + 1) if own[-1] + 1 < len(recording.step) else own


def test_travellers(recording, curves):
    np.testing.assert_allclose(curves[0, "agent_agent"].value, 4.0 - 2.0)  # 4 m apart, radii 1 and 1
    assert curves[0, "agent_object"].value.min() == pytest.approx(np.hypot(2.0, 0.2) - 1.4)
    np.testing.assert_array_equal(curves[0, "agent_agent"].time, recording.time[rows(recording, 0)])


def test_who_grasps_may_touch(recording, curves):
    idle = np.linalg.norm(recording.centre["b"][rows(recording, 1)] - [0, 15, 0.3], axis=1) - 1.5
    np.testing.assert_allclose(curves[1, "agent_object"].value, idle, atol=0.02)  # least up to the next sample


def test_teams_are_one_sphere(recording, curves):
    origin = recording.object_origin["crate"][rows(recording, 2)]
    expected = np.linalg.norm(origin - [0, 15, 0.3], axis=1) - 3.5
    # The curve has the least distance between a sample and the next, half a metre on.
    assert (curves[2, "team_other"].value <= expected + 1e-12).all()
    np.testing.assert_allclose(curves[2, "team_other"].value, expected, atol=0.6)
    assert {step for step, kind in curves if kind == "team_other"} == {2}
