"""The whole chain in four calls: measure, plan_and_place, simulate, then `drake_ltl.verification.verify`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import pydot
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, LeafSystem

from drake_ltl.diagrams import MakeMissionDiagram, MissionDiagram
from drake_ltl.errors import InvalidInputError, MissingDependencyError, Mistake, naming_file
from drake_ltl.execution.recovery import FaultRun, RunWithFaults
from drake_ltl.execution.runner import Run, RunMission, RunProgress
from drake_ltl.multibody import MeasuredModels, MeasureGeometry
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.geometric_fits import GeometricFits
from drake_ltl.planning.mission import Mission
from drake_ltl.planning.mission_planner import plan_mission
from drake_ltl.scenario.model import Scenario
from drake_ltl.scenario.starts import check_starts
from drake_ltl.systems.preflight import check_fields
from drake_ltl.visualization.live_control import LiveControl
from drake_ltl.visualization.live_page import ServeLivePage
from drake_ltl.visualization.meshcat_scene import LOCALHOST, MakeMeshcat
from drake_ltl.visualization.page_data import live_page_data, recorded_page_data
from drake_ltl.visualization.recorded_page import StartPage, WritePage
from drake_ltl.visualization.replay import PublishReplay
from drake_ltl.whole_files import write_text_whole


def measure(scenario: Scenario) -> MeasuredModels:
    """Loads the scenario's models. Raises InvalidInputError if one cannot be used."""
    return MeasureGeometry(scenario)


def plan_and_place(scenario: Scenario, models: MeasuredModels) -> Mission:
    """The cheapest mission found whose bodies can be placed.

    Raises:
        InvalidInputError: a body starts outside every region, or touches another.
        InfeasibleError: nothing satisfies the specification, or nothing that does can be carried out.
    """
    starts = check_starts(scenario, models.geometry)
    fits = None if scenario.fits is None else published_fits(scenario.fits)
    return plan_mission(scenario, models.geometry, starts, fits=fits)


def num_steps(mission: Mission, suffix_rounds: int) -> int:
    """Steps up to the first state of the suffix, and that many rounds from there."""
    return len(mission.plan.prefix) + suffix_rounds * len(mission.plan.suffix)


def simulate(
    mission: Mission,
    scenario: Scenario,
    models: MeasuredModels,
    *,
    suffix_rounds: int = 1,
    keep_going: bool = False,
    live: bool = False,
    meshcat_host: str = LOCALHOST,
    realtime_rate: float = 1.0,
    page: Path | None = None,
    graphviz: Path | None = None,
    disturb: Callable[[MissionDiagram, Context], None] | None = None,
    own_controllers: Mapping[str, LeafSystem] | None = None,
    report: Callable[[RunProgress], None] | None = None,
    announce: Callable[[str], None] = print,
) -> Run:
    """Carries the mission out in Drake's Simulator.

    Args:
        keep_going: what monitors see is recorded, but does not end the run.
        live: show the run in a browser while it goes on; `announce` is told the address.
        meshcat_host: address of this computer at which the browser finds it, see `MakeMeshcat`.
        realtime_rate: at which a live run begins; 0 for as fast as the computer can.
        page: write a page here that replays the run.
        graphviz: write the diagram of systems here, as DOT, or as SVG if the name ends so.
        disturb: changes the context in which the run starts, which controllers know nothing of (masses, for instance).
        own_controllers: systems in place of some controllers: see `drake_ltl.diagrams.MakeMissionDiagram`.
        report: told of the progress once per simulated second.

    Raises:
        InvalidInputError: the controller's settings do not suit the mission, or the scenario has `faults:` and what is
            asked for is not for such runs (`live`, `graphviz`, own controllers).
    """
    if scenario.faults:
        refused = {"live pages": live, "controllers of one's own": own_controllers, "drawings of its diagram": graphviz}
        _refuse([name for name, value in refused.items() if value])
        return _simulate_with_faults(
            mission, scenario, models, suffix_rounds, keep_going, page, disturb, report, announce
        )
    steps = num_steps(mission, suffix_rounds)
    meshcat = MakeMeshcat(host=meshcat_host if live else LOCALHOST) if live or page is not None else None
    diagram = MakeMissionDiagram(
        mission, scenario, models, num_steps=steps, meshcat=meshcat, own_controllers=own_controllers
    )
    check_fields(diagram.program, scenario, models)
    for formula, reason in diagram.monitors["word"].unwatched.items():
        announce(f"the run is not watched for {formula}: {reason}")
    if graphviz is not None:
        write_graphviz(diagram.diagram, graphviz)
    pace = LiveControl(meshcat, diagram, scenario, steps, rate=realtime_rate) if live else None
    if pace is not None:
        server = ServeLivePage(meshcat, live_page_data(mission, scenario), pace.answer, meshcat_host)
        announce(f"watch at {server.url}")
    if page is not None:
        StartPage(meshcat, live=live)
    context = diagram.CreateStartContext()
    if disturb is not None:
        disturb(diagram, context)
    simulator = Simulator(diagram.diagram, context)
    result = RunMission(diagram, num_steps=steps, keep_going=keep_going, report=report, simulator=simulator, pace=pace)
    if page is not None:
        WritePage(meshcat, page, recorded_page_data(result.recording, scenario))
    return result


def _refuse(what: list[str]) -> None:
    if what:
        remedy = "leave these out, or the block `faults:` (--record shows such a run afterwards)"
        raise InvalidInputError(
            [Mistake("faults", f"a run in which something goes wrong has no {name}", remedy) for name in what]
        )


def _simulate_with_faults(
    mission: Mission,
    scenario: Scenario,
    models: MeasuredModels,
    suffix_rounds: int,
    keep_going: bool,
    page: Path | None,
    disturb: Callable[[MissionDiagram, Context], None] | None,
    report: Callable[[RunProgress], None] | None,
    announce: Callable[[str], None],
) -> FaultRun:
    """Faults are noticed and recovered from (docs/faults.md); `announce` is told of each."""
    fits = GeometricFits(scenario, models.geometry) if scenario.fits is None else published_fits(scenario.fits)
    run = RunWithFaults(
        mission,
        scenario,
        models,
        fits,
        suffix_rounds=suffix_rounds,
        keep_going=keep_going,
        report=report,
        disturb=disturb,
    )
    for noticed in run.noticed:
        announce(str(noticed))
    if page is not None:
        meshcat = MakeMeshcat()
        StartPage(meshcat)
        PublishReplay(run.recording, scenario, models, meshcat)
        WritePage(meshcat, page, recorded_page_data(run.recording, scenario))
    return run


def write_graphviz(diagram: Diagram, path: Path) -> None:
    """Writes the diagram of systems as DOT, or as SVG if the name ends in `.svg`.

    Raises:
        MissingDependencyError: SVG is asked for and Graphviz is not installed.
    """
    dot = diagram.GetGraphvizString(max_depth=1)
    if path.suffix != ".svg":
        with naming_file(path):
            write_text_whole(path, dot)
        return
    (graph,) = pydot.graph_from_dot_data(dot)
    try:
        graph.write_svg(str(path))
    except FileNotFoundError as error:
        raise MissingDependencyError("SVG needs Graphviz (Debian's `graphviz`); a name in .dot does not") from error
