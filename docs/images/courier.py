"""Makes courier.png from examples/courier.yaml: python docs/images/courier.py

The step in which two porters carry the crate while a courier on two driven wheels travels, from the mission's report.
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import drake_ltl
from drake_ltl.visualization.figures import write_report_figures

HERE = Path(__file__).parent
STEP = 3


def main() -> None:
    """Writes the picture next to this script."""
    scenario = drake_ltl.load("courier")
    run = drake_ltl.simulate(scenario)
    assert drake_ltl.verify(run, scenario).satisfied
    with tempfile.TemporaryDirectory() as folder:
        write_report_figures(run.recording, scenario, folder)
        shutil.copy(Path(folder) / f"step_{STEP:02}.png", HERE / "courier.png")


if __name__ == "__main__":
    main()
