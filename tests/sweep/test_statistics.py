"""Summaries of outcomes."""

from __future__ import annotations

import itertools
import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.image import imread
from rich.console import Console

from drake_ltl.sweep.figure import write_summary_figure
from drake_ltl.sweep.outcome import STATUSES, Outcome
from drake_ltl.sweep.statistics import quantity, share, summarize
from drake_ltl.sweep.table import MOST_REASONS, summary_table, summary_to_json
from drake_ltl.verification.clearances import KINDS


@given(st.integers(1, 400).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_wilson_s_interval(numbers):
    """By its formula, with the normal quantile of 95 %."""
    k, n = numbers
    z, p = 1.959963984540054, k / n
    middle = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    found = share(k, n, "wilson")
    assert (found.low, found.high) == pytest.approx((middle - half, middle + half), abs=1e-12)


def test_no_collision_in_many_runs():
    """The exact bound solves (1 - p)^n = 2.5 %."""
    found = share(0, 1000, "exact")
    assert found.low == 0.0
    assert found.high == pytest.approx(1.0 - 0.025 ** (1 / 1000), rel=1e-9)


def test_nothing_is_known_of_no_runs():
    assert (share(0, 0, "wilson").low, share(0, 0, "exact").high) == (0.0, 1.0)
    assert summarize([]).quantities == ()


@settings(max_examples=20)
@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=30))
def test_the_numbers_of_a_quantity(values):
    found = quantity("x", "m", values, range(len(values)))
    assert found.least == values[found.least_run] == min(values)
    assert found.greatest == values[found.greatest_run] == max(values)
    assert found.mean == pytest.approx(np.mean(values))
    if len(values) == 1:
        assert found.mean_low is found.mean_high is None
    else:
        assert min(values) - 1e-9 <= found.mean_low <= found.mean + 1e-9
        assert found.mean - 1e-9 <= found.mean_high <= max(values) + 1e-9


def test_the_mean_s_interval_covers_as_often_as_it_says():
    """Of 60 samples of 40 normal numbers: 95 % on average; fewer than 51 have a probability below 0.2 %."""
    rng = np.random.default_rng(0)
    found = [quantity("x", "m", rng.normal(size=40), range(40)) for _ in range(60)]
    assert 51 <= sum(one.mean_low <= 0.0 <= one.mean_high for one in found) <= 60
    assert all(one.mean_high - one.mean_low < 1.0 for one in found)  # 4 / sqrt(40) on average 0.62


def test_the_order_of_ending_does_not_matter(outcome):
    outcomes = [outcome(0), outcome(1, "violated"), outcome(2, clearance=-0.5), Outcome(3, "failed", reason="x")]
    expected = summarize(outcomes)
    assert all(summarize(order) == expected for order in itertools.permutations(outcomes))


def test_what_is_counted(outcome):
    outcomes = [
        outcome(0),
        outcome(1, "stalled", clearance=0.0),
        outcome(2, "violated", clearance=-0.1),
        Outcome(3, "no plan", reason="there is none"),
        outcome(4),
    ]
    summary = summarize(outcomes)
    assert summary.statuses == {"satisfied": 2, "violated": 1, "stalled": 1, "no plan": 1, "failed": 0}
    assert tuple(summary.statuses) == STATUSES
    assert (summary.satisfied.count, summary.satisfied.of) == (2, 5)
    assert (summary.collided.count, summary.collided.of) == (2, 4)  # of those that were simulated
    rows = {row.name: row for row in summary.quantities}
    assert rows["simulated time"].count == 2  # of those that were satisfied
    assert (rows["simulated time"].least, rows["longest step"].greatest) == (3.0, 6.0)
    assert (rows["agent_agent"].count, rows["agent_agent"].least, rows["agent_agent"].least_run) == (4, -0.1, 2)
    assert "team_other" not in rows


def text_of(summary, runs: int) -> str:
    console = Console(width=120, file=None, record=True, quiet=False)
    with console.capture() as capture:
        console.print(summary_table(summary, "patrol", runs))
    return capture.get()


def test_the_table(outcome):
    good = summarize([outcome(0), outcome(1)])
    assert text_of(good, 2).startswith("ALL SATISFIED  patrol, 2 of 2 runs")
    assert text_of(good, 3).startswith("UNFINISHED  patrol, 2 of 3 runs")
    bad = text_of(summarize([outcome(0), *(outcome(k, "stalled") for k in range(1, 25))]), 25)
    assert bad.startswith("NOT ALL")
    assert "run 7, stalled: step 1, 1.000 s: it is stalled" in bad
    assert f"and {24 - MOST_REASONS} more" in bad
    assert "gap of a weld, mm" in bad


def test_the_table_fits_a_pipe(outcome):
    """With numbers of usual size nothing is cut off."""
    usual = {"min_clearance": dict.fromkeys(KINDS, 12.3456), "simulated_seconds": 123.456, "durations": (12.3456,)}
    runs = [outcome(k, **usual) for k in (1234, 1235)]
    text = text_of(summarize(runs), 2)
    assert "clearance to the workspace's border, m" in text
    assert "…" not in text


def test_the_json_is_the_same_whenever_it_is_made(outcome):
    def summary(wall: float) -> dict:
        return summary_to_json(summarize([outcome(0, wall_seconds=wall), outcome(1, "stalled")]), {"seed": 3}, 4)

    data = summary(1.0)
    assert json.loads(json.dumps(data, allow_nan=False)) is not None
    assert data == summary(2.0)
    assert (data["runs"], data["done"]) == (4, 2)
    assert [one["run"] for one in data["unsatisfied"]] == [1]


def test_the_picture(outcome, case_ii, tmp_path):
    positions = {member.name: member.position for member in (*case_ii.agents, *case_ii.objects)}
    drawn = type(outcome(0).drawn)(positions, {}, {})
    for name, outcomes in (
        ("full", [outcome(0, drawn=drawn), outcome(1, "stalled", drawn=drawn, clearance=-0.1)]),
        ("empty", []),
        ("failed", [Outcome(0, "failed", reason="x")]),
    ):
        write_summary_figure(summarize(outcomes), case_ii, tmp_path / f"{name}.png")
    pictures = {path.stem: imread(path) for path in tmp_path.glob("*.png")}
    assert set(pictures) == {"full", "empty", "failed"}
    assert pictures["full"].std() > pictures["empty"].std() > 0.0
