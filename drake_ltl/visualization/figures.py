"""All figures of a run, from its recording alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from drake_ltl.execution.recording import Recording
from drake_ltl.scenario.model import Scenario
from drake_ltl.verification.data import finite_part
from drake_ltl.visualization.force_figures import TeamForce, effort_drawings, force_drawings
from drake_ltl.visualization.gantt_figure import gantt_drawing
from drake_ltl.visualization.style import Drawing
from drake_ltl.visualization.time_figures import clearance_drawing, lyapunov_drawing
from drake_ltl.visualization.trajectory_figures import sheet_drawing, step_drawings


def run_drawings(
    recording: Recording, scenario: Scenario, forces: Callable[[], Sequence[TeamForce]] = tuple
) -> list[Drawing]:
    """Every figure of a run; none of one that ended before its first sample.

    Args:
        scenario: the one the recording was made of; it knows the workspace and its regions.
        forces: works out those of the run (`team_forces`), which takes the scenario's models.
    """
    recording = finite_part(recording)
    if not len(recording.time):
        return []
    sheet = [sheet_drawing(recording, scenario)] if recording.steps else []
    over_time = [gantt_drawing(recording), clearance_drawing(recording, scenario), lyapunov_drawing(recording)]
    loads = [*effort_drawings(recording), *force_drawings(recording, forces())]
    return [*step_drawings(recording, scenario), *sheet, *over_time, *loads]


def write_report_figures(
    recording: Recording, scenario: Scenario, directory: Path | str, formats: Sequence[str] = ("png",)
) -> list[Path]:
    """Writes every figure into `directory` (made if it is not there) and returns the files.

    Args:
        formats: of `png`, `svg` and `pdf`.

    Raises:
        OSError: a file cannot be written.
    """
    directory = Path(directory)
    directory.mkdir(parents=True, exist_ok=True)
    return [path for drawing in run_drawings(recording, scenario) for path in drawing.write(directory, formats)]
