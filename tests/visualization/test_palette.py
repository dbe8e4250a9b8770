import itertools

import numpy as np
import pytest

from drake_ltl.visualization.palette import AGENT_HUES, OBJECT_HUES, agent_colours, hex_code, mixed, object_colours

# Machado, Oliveira and Fernandes (2009), severity 1, on linear RGB.
SEEN_BY = {
    "all cones": np.eye(3),
    "no red cones": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "no green cones": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
}
TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])


def lab(colour, eyes: str) -> np.ndarray:
    """CIELAB of an sRGB colour as these eyes see it."""
    srgb = np.asarray(colour)
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    xyz = TO_XYZ @ np.clip(SEEN_BY[eyes] @ linear, 0, 1) / TO_XYZ.sum(axis=1)
    x, y, z = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("eyes", SEEN_BY)
@pytest.mark.parametrize("hues", [AGENT_HUES, OBJECT_HUES], ids=["agents", "objects"])
def test_hues_of_a_kind_look_different_to_everybody(hues, eyes):
    # A difference of 2.3 can just be noticed side by side; on lines far apart one needs several times that.
    for first, second in itertools.combinations(hues, 2):
        assert np.linalg.norm(lab(first, eyes) - lab(second, eyes)) > 10.0


def test_large_teams_never_share_a_colour():
    agents, objects = [f"a{i}" for i in range(24)], [f"o{i}" for i in range(12)]
    codes = [hex_code(c) for c in (*agent_colours(agents).values(), *object_colours(objects).values())]
    assert len(set(codes)) == 36


def test_mixing_ends_at_either_colour():
    black, red = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)
    assert mixed(black, red, 0.0) == black
    assert mixed(black, red, 1.0) == red
    assert hex_code(mixed(black, red, 0.5)) == "#800000"
