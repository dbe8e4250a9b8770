"""Bars of what agents did."""

from __future__ import annotations

from matplotlib.figure import Figure

from drake_ltl.visualization.gantt_figure import bars, gantt_drawing


def test_bars_follow_modes_and_grasps(recording):
    found = [(bar.kind, bar.label) for bar in bars(recording, "b")]
    assert found == [("travel", "east"), ("reach", "crate"), ("carry", "crate to west"), ("hold", "crate")]


def test_bars_meet_where_steps_begin(recording):
    found = list(bars(recording, "a"))
    assert [bar.start for bar in found] == [step.start for step in recording.steps]
    assert [bar.end for bar in found[:-1]] == [step.start for step in recording.steps[1:]]
    assert found[-1].end == recording.time[-1]


def test_everybody_has_a_row(recording):
    figure = Figure()
    gantt_drawing(recording).draw(figure)
    (axes,) = figure.axes
    assert [label.get_text() for label in axes.get_yticklabels()] == ["a", "b"]
    assert {"crate", "east"} <= {text.get_text() for text in axes.texts}
