"""Violations: one for each thing, the first with the worst, on one line."""

from __future__ import annotations

import numpy as np

from drake_ltl.verification.violations import Violation, merged, where_bad

OVERLAP = Violation("clearance", ("a1", "a2"), "a1 and a2 overlap", step=2, unit="m")


def test_first_and_worst():
    (found,) = where_bad(OVERLAP, np.array([False, True, True, False]), np.array([9.0, 0.1, 0.2, 9.0]), np.arange(4.0))
    assert (found.time, found.worst, found.worst_time) == (1.0, 0.2, 2.0)
    assert str(found) == "step 3, 1.000 s: a1 and a2 overlap: 0.2 m (at 2.000 s)"


def test_nothing_bad():
    assert where_bad(OVERLAP, np.zeros(3, dtype=bool), np.ones(3), np.arange(3.0)) == []


def test_merged_keeps_the_first_occurrence_and_the_worst_amount():
    def at(time: float, worst: float, **changes) -> Violation:
        return Violation("clearance", ("a1", "a2"), "overlap", time, int(time), worst, time + 0.5, "m", **changes)

    other = Violation("rest", ("a1",), "not at rest", 2.0, 2)
    formula = Violation("formula", ("a1",), "violated")
    found = merged([formula, at(3.0, 0.1), other, at(1.0, 0.02), at(5.0, 0.04)])
    assert [v.kind for v in found] == ["clearance", "rest", "formula"]
    assert (found[0].time, found[0].step, found[0].worst, found[0].worst_time) == (1.0, 1, 0.1, 3.5)


def test_one_line_each():
    assert str(Violation("formula", ("a1",), "a1 does not")) == "whole run: a1 does not"
    assert str(Violation("weld", ("a1",), "gapes", 1.0, 0, 4e-3, 1.0, "m")) == "step 1, 1.000 s: gapes: 4 mm"
    assert str(Violation("weld", ("a1",), "is turned", 1.0, 0, np.pi / 180, 1.0, "rad")).endswith(": 1 degrees")
