"""Every example loads, and plans or is impossible for the reason that it was written for."""

from __future__ import annotations

import functools
from importlib import import_module
from pathlib import Path

import pytest

from drake_ltl.errors import InfeasibleError
from drake_ltl.planning.explanation import explain_infeasible
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.geometric_fits import GeometricFits
from drake_ltl.planning.initial import initial_state
from drake_ltl.planning.methods import plan_by
from drake_ltl.scenario import load
from drake_ltl.scenario.starts import check_starts

EXAMPLES = Path(__file__).parent.parent / "examples"
ALL = sorted(path.stem for path in EXAMPLES.glob("*.yaml"))
IMPOSSIBLE = ["forbidden_room"]
COSTS = {
    "patrol": 58.82,
    "hospital_cart": 2146.0,
    "warehouse": 2136.0,
    "case_i": 14928.0,
    "case_ii": 7827.0,
    "example_1": 5492.0,
    "gathering": 2904.0,
    "turned_crate": 725.0,
    "spare_hand": 972.0,
    "courier": 1337.5,
    "crossing": 81.12,
}
"""J of the plan, proven least; sums of squared distances of regions, exact but for rounding."""
LARGE = ["example_1"]
"""Only the bounded method plans these."""


@functools.cache
def problem(name: str):
    """Scenario, initial state and P_s."""
    from drake_ltl.multibody import MeasureGeometry

    scenario = load(EXAMPLES / f"{name}.yaml")
    geometry = MeasureGeometry(scenario).geometry
    fits = GeometricFits(scenario, geometry) if scenario.fits is None else published_fits(scenario.fits)
    return scenario, initial_state(scenario, check_starts(scenario, geometry)), fits


def test_each_is_listed_with_a_sentence():
    listing = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    for name in ALL:
        assert f"[{name}.yaml]({name}.yaml)" in listing
        first = (EXAMPLES / f"{name}.yaml").read_text(encoding="utf-8").splitlines()[0]
        assert first.startswith("# ")
        assert len(first) > 40


@pytest.mark.parametrize("name", ALL)
def test_each_is_named_after_its_file(name):
    assert load(EXAMPLES / f"{name}.yaml").name == name


@pytest.mark.parametrize("name", [name for name in ALL if name not in IMPOSSIBLE])
def test_each_has_a_plan(name):
    """Its formulas are checked on the plan by the planner's own certificate."""
    scenario, start, fits = problem(name)
    found, _ = plan_by("bounded" if name in LARGE else "explicit", scenario, start, fits)
    assert found.status == "optimal"
    assert found.cost == pytest.approx(COSTS[name], rel=1e-9)


def test_the_forbidden_room_is_impossible_for_its_reason():
    scenario, start, fits = problem("forbidden_room")
    with pytest.raises(InfeasibleError):
        plan_by("explicit", scenario, start, fits)
    explanation = explain_infeasible(scenario, start, fits)
    assert explanation.verified
    text = str(explanation)
    for reason in ("strong must never enter lab", "crate must visit lab at some time", "crate needs power 4"):
        assert reason in text


@pytest.mark.mission
@pytest.mark.parametrize("name", ["patrol", "hospital_cart", "turned_crate", "crossing"])
def test_a_mission_is_carried_out(name):
    run(load(EXAMPLES / f"{name}.yaml"))


def run(scenario) -> None:
    from drake_ltl import mission
    from drake_ltl.verification import verify

    models = mission.measure(scenario)
    planned = mission.plan_and_place(scenario, models)
    verdict = verify(mission.simulate(planned, scenario, models).recording, scenario)
    assert verdict.satisfied, verdict.violations


@pytest.mark.mission
@pytest.mark.parametrize("script", ["own_controller", "transport_by_hand"])
def test_a_script_that_builds_a_diagram_does_what_it_says(script, capsys):
    """tune_kappa has tests of what it calls."""
    assert import_module(f"drake_ltl.examples.{script}").main() == 0, capsys.readouterr().out


def test_each_script_is_listed():
    listing = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    for path in EXAMPLES.glob("[!_]*.py"):
        assert path.name in listing
