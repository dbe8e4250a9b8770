"""What a differential drive's model says of itself, and which models are refused."""

from __future__ import annotations

import numpy as np
import pytest
from drake_ltl.models import package_xml

from drake_ltl.errors import InvalidInputError
from drake_ltl.multibody.differential_drive_model import DifferentialDriveModel

TEXT = (package_xml().parent / "bases" / "differential_drive.urdf").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def model() -> DifferentialDriveModel:
    return DifferentialDriveModel("a1")


def test_sizes(model):
    assert (model.wheel_radius, model.half_track, model.height) == pytest.approx((0.1, 0.2, 0.1))
    assert model.effort == 2.5
    assert np.hypot(0.25, 0.09) <= model.radius <= 0.27  # the chassis' upper rim, but for its polygon


def test_reduced_inertias_count_the_wheels_turning(model):
    spin, across, mass = 0.0025, 0.00131667, 0.5
    assert model.mass == pytest.approx(8.0 + 2.0 * mass + 2.0 * spin / 0.1**2, rel=1e-9)
    expected = 0.25 + 2.0 * (across + mass * 0.2**2) + 2.0 * spin * (0.2 / 0.1) ** 2
    assert model.inertia == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('<joint name="left" type="continuous">', '<joint name="left" type="fixed">', "'left'"),
        ('name="left"', 'name="port"', "no wheel on a revolute joint 'left'"),
        ('<frame name="bounding_centre"', '<frame name="middle"', "no frame 'bounding_centre'"),
        ('xyz="0 0.2 0.1"', 'xyz="0 0.25 0.1"', "its wheels at"),
        ('xyz="0 0.2 0.1"', 'xyz="0.1 0.2 0.1"', "its wheels at"),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 -1 0"/>', "axes are not y"),
        ('<origin xyz="0 0 0.12"/>\n      <mass', '<origin xyz="0.05 0 0.12"/>\n      <mass', "centre of mass"),
        ('link="base" xyz="0 0 0.1"', 'link="base" xyz="0.1 0 0.1"', "'bounding_centre' at"),
        ('a="0.1" b="0.02" c="0.1"', 'a="0.12" b="0.02" c="0.12"', "reaches down to z"),
        ("<robot", "<robt", "does not parse"),
    ],
)
def test_what_the_law_cannot_drive_is_refused(tmp_path, old, new, message):
    assert old in TEXT
    path = tmp_path / "changed.urdf"
    path.write_text(TEXT.replace(old, new))
    with pytest.raises(InvalidInputError, match=message) as caught:
        DifferentialDriveModel("a1", str(path))
    for mistake in caught.value.mistakes:
        assert mistake.where == "a1.model"
        assert "\n" not in str(mistake)


@pytest.mark.parametrize("model", ["no/such.urdf", "package://other/a.urdf", "http://a/b.urdf"])
def test_files_that_are_none_are_refused(model):
    with pytest.raises(InvalidInputError, match=r"a1\.model"):
        DifferentialDriveModel("a1", model)
