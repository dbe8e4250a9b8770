"""Who moves though no navigation function moves it: idle, at a grasp, or after it has let go of what it carried."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

from drake_ltl.execution.recording import NOTHING, Recording
from drake_ltl.verification import verify

GRASP, CARRY = 1, 2


@pytest.fixture
def recording(draw: Callable[[int], Recording]) -> Recording:
    """It ends early, before a2 grasps again, which nobody does whom a fault has befallen."""
    return dataclasses.replace(draw(4), completed=False, reason="early")


def shifted(recording: Recording, name: str, step: int, way: tuple[float, float]) -> Recording:
    """An agent goes there and back in the midst of a step, smoothly; its velocities are not looked at here."""
    along = np.sin(np.pi * np.clip((recording.time - step - 0.6) / 0.3, 0.0, 1.0)) ** 2
    centre = recording.centre[name] + along[:, None] * [*way, 0.0]
    return dataclasses.replace(recording, centre=recording.centre | {name: centre})


def halted(recording: Recording, fault: str, faulty: str) -> Recording:
    """In the step in which a1 and a2 carry o1, from 2 s to 3 s."""
    steps = list(recording.steps)
    steps[CARRY] = dataclasses.replace(steps[CARRY], halted="noticed", faulty=(faulty,))
    return dataclasses.replace(recording, scenario=f"{recording.scenario}\nfaults: [{fault}]\n", steps=tuple(steps))


def letting_go(recording: Recording) -> Recording:
    """a2 holds nothing from 2.5 s on."""
    grasp = recording.grasp.copy()
    grasp[recording.time >= 2.5, 1] = NOTHING
    recording = halted(recording, "{kind: weld_breaks, agent: a2, time: 2.2}", "a2")
    return dataclasses.replace(recording, grasp=grasp)


def said(recording: Recording) -> list[str]:
    return [violation.what for violation in verify(recording).violations]


def roams(recording: Recording, name: str) -> bool:
    return any(f"{name} moves by more than" in what and "navigation" in what for what in said(recording))


@pytest.mark.parametrize(("way", "found"), [(0.05, False), (0.07, True)])
def test_who_idles_stands(recording, way, found):
    """Within its region."""
    assert roams(shifted(recording, "a3", CARRY, (0.0, way)), "a3") == found


@pytest.mark.parametrize(("since", "found"), [("0.5", False), ("2.95", True)])
def test_who_is_out_of_service_may_creep_to_rest(recording, since, found):
    run = halted(recording, "{kind: mass, object: o1, factor: 1.1}", "o1")
    fault = f"faults: [{{kind: agent_stops, agent: a3, time: {since}}}, "
    run = dataclasses.replace(run, scenario=run.scenario.replace("faults: [", fault))
    assert roams(shifted(run, "a3", GRASP, (0.0, 0.4)), "a3") == found


@pytest.mark.parametrize(("aside", "found"), [(0.1, False), (0.5, True)])
def test_who_grasps_only_reaches(recording, aside, found):
    """By the 25 cm from stand-off to grasp."""
    assert roams(shifted(recording, "a2", GRASP, (aside, 0.0)), "a2") == found


def test_reaches_of_large_spheres_are_longer(recording):
    wide = dataclasses.replace(recording, agent_radius=dict.fromkeys(recording.agents, 1.0))
    wide = dataclasses.replace(wide, scenario=wide.scenario.replace("radius: 0.7", "radius: 1.0"))
    assert not roams(shifted(wide, "a2", GRASP, (0.4, 0.0)), "a2")
    assert roams(shifted(wide, "a2", GRASP, (0.8, 0.0)), "a2")


def test_who_has_let_go_brakes(recording):
    assert roams(letting_go(recording), "a2")  # it goes on with o1, 2 m and more


def test_who_has_let_go_is_a_body_like_any_other(recording):
    """a2 goes through a3, which the sphere of its team keeps clear of."""
    run = letting_go(recording)
    others = run.centre["a3"].copy()
    others[:] = run.centre["a2"][140] + [0.0, 3.0, 0.0]
    run = dataclasses.replace(run, centre=run.centre | {"a3": others})
    for way, found in ((0.0, False), (2.0, True)):
        seen = verify(shifted(run, "a2", CARRY, (0.0, way))).violations
        assert any(v.step == CARRY and v.what == "a2 and a3 overlap" for v in seen) == found
