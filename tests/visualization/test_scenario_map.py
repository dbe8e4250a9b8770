"""The map of a scenario at its start."""

from __future__ import annotations

import dataclasses
import math

import pytest
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from drake_ltl.scenario.starts import check_starts
from drake_ltl.visualization.scenario_map import MOST_LINES, fill_map


@pytest.fixture(scope="module")
def starts(case_ii, models):
    return check_starts(case_ii, models.geometry)


def drawn(scenario, models, starts) -> Figure:
    figure = Figure()
    fill_map(figure, scenario, models.geometry, starts)
    return figure


def test_everything_is_named_once(case_ii, models, starts):
    axes, _ = drawn(case_ii, models, starts).axes
    texts = [text.get_text() for text in axes.texts]
    assert sorted(texts[:-1]) == sorted((*case_ii.region_names, *case_ii.agent_names, *case_ii.object_names))
    assert texts[-1] == "10 m"


def test_bodies_stand_where_they_start_with_their_radii(case_ii, models, starts):
    axes, _ = drawn(case_ii, models, starts).axes
    circles = [(*patch.center, patch.radius) for patch in axes.patches if isinstance(patch, Circle)]
    bodies = [(start.p_WC, models.geometry.agent_radius[name]) for name, start in starts.agents.items()]
    bodies += [(start.p_WO, models.geometry.object_radius[name]) for name, start in starts.objects.items()]
    bodies += [(region.centre, region.radius) for region in case_ii.regions]
    bodies.append(((0.0, 0.0, 0.0), case_ii.workspace_radius))
    assert sorted(circles) == sorted((*p[:2], radius) for p, radius in bodies)


def test_squares_lie_within_the_objects_spheres(case_ii, models, starts):
    axes, _ = drawn(case_ii, models, starts).axes
    squares = [patch for patch in axes.patches if not isinstance(patch, Circle)]
    assert len(squares) == len(case_ii.objects)
    for square, (name, start) in zip(squares, starts.objects.items(), strict=True):
        for corner in square.get_corners():
            distance = math.dist(corner, start.p_WO[:2])
            assert distance == pytest.approx(models.geometry.object_radius[name], rel=1e-9)


def test_long_formulas_are_broken_and_very_long_lists_cut(case_ii, models, starts):
    long = " & ".join(["F(a1.pi2 & o1.pi4)"] * 400)
    _, beside = drawn(dataclasses.replace(case_ii, spec=long), models, starts).axes
    texts = [text.get_text() for text in beside.texts]
    assert len(texts) == MOST_LINES
    assert texts[-1] == "..."
    assert max(map(len, texts)) <= 45
