"""The map of a scenario as SVG, for notebooks."""

from __future__ import annotations

import io
import re

import matplotlib as mpl
from matplotlib.figure import Figure

from drake_ltl.api import planning_geometry
from drake_ltl.scenario.model import Scenario
from drake_ltl.scenario.starts import check_starts
from drake_ltl.visualization.scenario_map import SIZE, fill_map

_SIZE = re.compile(r' width="[0-9.]+pt" height="[0-9.]+pt"')
"""Of the whole picture: left out, so that it is as wide as there is room."""


def map_svg(scenario: Scenario) -> str:
    """The map that `drake-ltl draw` writes, as an <svg> element.

    Raises:
        InvalidInputError: a model cannot be used, or a body starts where it may not.
    """
    geometry = planning_geometry(scenario)
    figure = Figure(figsize=SIZE, layout="constrained")
    fill_map(figure, scenario, geometry, check_starts(scenario, geometry))
    stream = io.StringIO()
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": scenario.name}):  # the same text every time
        figure.savefig(stream, format="svg", metadata={"Date": None})
    text = stream.getvalue()
    return _SIZE.sub(' style="width:100%;max-width:46rem;height:auto"', text[text.index("<svg") :], count=1)
