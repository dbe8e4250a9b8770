"""What `import drake_ltl` offers: load, plan, simulate and verify, each usable without the others.

    scenario = drake_ltl.load("errand.yaml")
    plan = drake_ltl.plan(scenario)             # or one of your own: drake_ltl.own_plan
    run = drake_ltl.simulate(scenario, plan)    # own_controllers: LeafSystems of yours
    verdict = drake_ltl.verify(run)             # or of any recording

Planning loads Drake only if the file leaves out numbers that are then measured from the models.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from drake_ltl.execution.recording import Recording
from drake_ltl.planning.fits import Fits, published_fits
from drake_ltl.planning.geometric_fits import GeometricFits
from drake_ltl.planning.geometry import Geometry
from drake_ltl.planning.initial import initial_state
from drake_ltl.planning.methods import Method, plan_by
from drake_ltl.planning.mission import Mission
from drake_ltl.planning.plan import Plan, State
from drake_ltl.planning_geometry import planning_geometry
from drake_ltl.scenario import load as load_file
from drake_ltl.scenario import loads
from drake_ltl.scenario.model import Scenario
from drake_ltl.scenario.starts import check_starts

if TYPE_CHECKING:
    from pydrake.systems.framework import LeafSystem

    from drake_ltl.execution.runner import Run, RunProgress
    from drake_ltl.verification import Verdict


def load(file: Path | str) -> Scenario:
    """The scenario in a file, or the example of that name (`drake_ltl.examples.names()` lists them).

    Raises:
        InvalidInputError: there is neither, or with every mistake of the file.
    """
    from drake_ltl import examples

    return load_file(examples.find(file))


def plan(scenario: Scenario, *, method: Method = "auto", time_limit: float | None = None) -> Plan:
    """A plan of least cost.

    Args:
        method: see `planning.methods.plan_by`.
        time_limit: for the bounded method [s].

    Raises:
        InvalidInputError: a model cannot be used, or a body starts outside every region or touches another.
        InfeasibleError: nothing satisfies the specification.
        SearchLimitError: the problem is too large for the method.
    """
    start, fits = planning_problem(scenario, planning_geometry(scenario))
    return plan_by(method, scenario, start, fits, time_limit=time_limit)[0]


def own_plan(scenario: Scenario, *, prefix: Sequence[str] = (), suffix: Sequence[str]) -> Plan:
    """A plan that you write yourself, one text for each step, such as `a1: depot -> dock; a2 grasps crate`.

    Raises:
        InvalidInputError: the first thing that is wrong with it; see `planning.own_plan.own_plan`.
    """
    from drake_ltl.planning.own_plan import own_plan

    start, fits = planning_problem(scenario, planning_geometry(scenario))
    return own_plan(scenario, start, fits, prefix, suffix)


def simulate(
    scenario: Scenario,
    plan: Plan | Mission | None = None,
    *,
    suffix_rounds: int | None = None,
    own_controllers: Mapping[str, LeafSystem] | None = None,
    live: bool = False,
    page: Path | str | None = None,
    report: Callable[[RunProgress], None] | None = None,
) -> Run:
    """Carries a plan out in Drake's Simulator.

    Args:
        plan: what to carry out; None plans first, and plans around what finds no places.
        suffix_rounds: rounds of the plan's loop; None takes the scenario's number.
        own_controllers: your systems in place of some controllers: see `drake_ltl.diagrams.MakeMissionDiagram`.
        live: show the run in a browser while it goes on.
        page: write a page here that replays the run.
        report: told of the progress once per simulated second.

    Raises:
        InvalidInputError: a model, a start, the controller's settings or a system of yours cannot be used.
        InfeasibleError: nothing satisfies the specification, or nothing that does can be carried out.
        PlacementError: the bodies of the given plan find no places.
    """
    from drake_ltl import mission

    models = mission.measure(scenario)
    if plan is None:
        plan = mission.plan_and_place(scenario, models)
    elif isinstance(plan, Plan):
        from drake_ltl.planning.placement import place

        plan = place(plan, scenario, models.geometry, check_starts(scenario, models.geometry))
    return mission.simulate(
        plan,
        scenario,
        models,
        suffix_rounds=scenario.simulation.suffix_rounds if suffix_rounds is None else suffix_rounds,
        live=live,
        page=None if page is None else Path(page),
        own_controllers=own_controllers,
        report=report,
    )


def verify(run: Run | Recording | Path | str, scenario: Scenario | None = None) -> Verdict:
    """Judges a run, a recording, or the file of one, from its data alone.

    Args:
        scenario: what the run should do; None takes the text that the recording carries.

    Raises:
        InvalidInputError: it is no recording of its scenario, or a model cannot be used.
    """
    from drake_ltl.verification import verify

    if isinstance(run, Path | str):
        run = Recording.load(run)
    recording = run if isinstance(run, Recording) else run.recording
    if scenario is None:
        scenario = loads(recording.scenario, source_name="the recording's scenario", check_models=False)
    return replace(verify(recording, scenario), scenario=scenario)


def planning_problem(scenario: Scenario, geometry: Geometry) -> tuple[State, Fits]:
    """Initial state and P_s.

    Raises:
        InvalidInputError: a body starts outside every region, or touches another.
    """
    start = initial_state(scenario, check_starts(scenario, geometry))
    fits = GeometricFits(scenario, geometry) if scenario.fits is None else published_fits(scenario.fits)
    return start, fits
