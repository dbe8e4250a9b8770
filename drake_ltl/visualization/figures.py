"""All figures of a run, from its recording alone."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from drake_ltl.execution.recording import Recording
from drake_ltl.scenario.model import Scenario
from drake_ltl.verification.data import finite_part
from drake_ltl.visualization.time_figures import clearance_figure, lyapunov_figure
from drake_ltl.visualization.trajectory_figures import trajectory_figures


def write_report_figures(
    recording: Recording, scenario: Scenario, directory: Path | str, formats: Sequence[str] = ("png",)
) -> list[Path]:
    """Writes every figure into `directory` (made if it is not there) and returns the files.

    Args:
        scenario: the one the recording was made of; it knows the workspace and its regions.
        formats: of `png`, `svg` and `pdf`.

    Raises:
        OSError: a file cannot be written.
    """
    directory = Path(directory)
    directory.mkdir(parents=True, exist_ok=True)
    recording = finite_part(recording)
    if not len(recording.time):
        return []
    return [
        *trajectory_figures(recording, scenario, directory, formats),
        *lyapunov_figure(recording, directory, formats),
        *clearance_figure(recording, scenario, directory, formats),
    ]
