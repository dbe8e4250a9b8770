"""Differential drives in Drake: wheels on a floor, nothing else."""

from __future__ import annotations

import runpy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from drake_ltl.diagrams.drive_diagram import Drive, DriveSettings, MakeDriveDiagram
from pydrake.geometry import Meshcat, MeshcatParams

from drake_ltl.errors import InvalidInputError
from drake_ltl.execution.drive_run import DriveRun, RunDrives
from drake_ltl.navigation import StaticBody
from drake_ltl.navigation.unicycle import UnicycleGains

EXAMPLE = Path(__file__).parents[2] / "examples" / "differential_drive.py"
DRIVES = [
    Drive("a1", (-1.2, 0.1, 0.3), (1.2, 0.0, 0.0)),
    Drive("a2", (1.2, 0.2, 3.0), (-1.2, 0.3, 2.0)),
]


@pytest.fixture(scope="module")
def run() -> DriveRun:
    """Two that pass each other in a narrow place."""
    return RunDrives(MakeDriveDiagram(DRIVES, obstacles=[StaticBody("pillar", 0.3, (0.0, -1.0, 0.1))]), time_limit=25.0)


def test_all_promises_hold(run):
    assert run.violations() == []
    assert run.arrived
    assert 0.0 < run.clearance.min() < 0.5  # they did pass each other
    for track in run.tracks.values():
        assert track.position_error <= 0.02
        assert track.heading_error <= 0.02
        assert track.parked[-1]


def test_a_drive_never_moves_sideways(run):
    """By where it was, not by its speed: what it moves between two samples lies along its heading."""
    for track in run.tracks.values():
        moved = np.diff(track.p, axis=0)
        h = np.column_stack([np.cos(track.theta), np.sin(track.theta)])[:-1]
        aside = h[:, 0] * moved[:, 1] - h[:, 1] * moved[:, 0]
        assert np.abs(aside).max() <= 1e-3 * np.diff(run.time).max()  # 1 mm/s


def test_report_names_each_drive(run):
    text = str(run)
    for word in ("all arrived", "least clearance", "a1: ", "a2: ", "slip at most"):
        assert word in text


def test_broken_promises_are_named(run):
    touching = replace(run.tracks["a1"], p=run.tracks["a2"].p)
    slipping = replace(run.tracks["a1"], aside=run.tracks["a1"].aside + 0.1)
    strained = replace(run.tracks["a1"], effort=1.5 * np.ones_like(run.tracks["a1"].effort))
    for track, word in ((touching, "spheres meet"), (slipping, "slip at 0.1"), (strained, "1.5 times")):
        (line,) = replace(run, tracks=run.tracks | {"a1": track}).violations()
        assert word in line
    (line,) = replace(run, lyapunov=np.linspace(0.0, 100.0, len(run.time))).violations()
    assert "V rises" in line
    assert replace(run, arrived=False).violations() == ["not all have arrived"]


def test_a_viewer_changes_nothing_that_is_measured():
    """It adds steps of its own to the simulator's, between which nothing moves."""
    meshcat = Meshcat(MeshcatParams(host="localhost", port=0))
    seen, unseen = (RunDrives(MakeDriveDiagram(DRIVES[:1], meshcat=m), time_limit=0.4) for m in (meshcat, None))
    np.testing.assert_allclose(np.diff(seen.time), DriveSettings().time_step, atol=1e-12)
    np.testing.assert_array_equal(seen.lyapunov, unseen.lyapunov)
    assert seen.tracks["a1"].lateral_slip == unseen.tracks["a1"].lateral_slip


def test_a_time_limit_ends_the_run():
    run = RunDrives(MakeDriveDiagram(DRIVES[:1]), time_limit=0.3)
    assert run.time[-1] == pytest.approx(0.3)
    assert run.violations() == ["not all have arrived"]
    assert np.isinf(run.clearance).all()


@pytest.mark.parametrize(
    ("drives", "where"),
    [
        ([DRIVES[0], replace(DRIVES[1], start=(-1.0, 0.0, 0.0))], "start: violates"),
        ([DRIVES[0], replace(DRIVES[1], goal=(1.0, 0.0, 0.0))], "goal: violates"),
        ([replace(DRIVES[0], goal=(7.9, 0.0, 0.0))], "goal: violates"),
        ([DRIVES[0], replace(DRIVES[1], name="a1")], "more than once"),
        ([replace(DRIVES[0], goal=(1.0, 0.0, np.nan))], "goal"),
        ([replace(DRIVES[0], model="none.urdf")], "is no file"),
    ],
)
def test_what_cannot_be_driven_is_refused(drives, where):
    with pytest.raises(InvalidInputError, match=where):
        MakeDriveDiagram(drives)


def test_settings_are_checked():
    with pytest.raises(InvalidInputError, match="force"):
        MakeDriveDiagram(DRIVES, DriveSettings(force=-1.0))
    with pytest.raises(InvalidInputError, match=r"controller\.kappa"):
        MakeDriveDiagram(DRIVES, DriveSettings(kappa=0.0))
    with pytest.raises(InvalidInputError, match=r"gains\.park"):
        DriveSettings(gains=UnicycleGains(park=-1.0))


def test_the_example_says_when_promises_do_not_hold(capsys):
    main = runpy.run_path(str(EXAMPLE))["main"]
    assert main(["--time-limit", "0.5"]) == 1
    assert "VIOLATED: not all have arrived" in capsys.readouterr().out


@pytest.mark.mission
def test_the_example_ends_satisfied(capsys):
    main = runpy.run_path(str(EXAMPLE))["main"]
    assert main([]) == 0
    assert capsys.readouterr().out.endswith("SATISFIED\n")
