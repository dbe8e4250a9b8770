"""The map of a scenario as SVG, for notebooks."""

from __future__ import annotations

import base64
import io

import matplotlib as mpl
from matplotlib.figure import Figure

from drake_ltl.planning_geometry import planning_geometry
from drake_ltl.scenario.model import Scenario
from drake_ltl.scenario.starts import check_starts
from drake_ltl.visualization.scenario_map import SIZE, fill_map


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
    return text[text.index("<svg") :]


def map_html(scenario: Scenario) -> str:
    """The same as an <img> that is as wide as there is room. Its data stand in it, so that no page's styles and no
    Markdown around it can harm it; raises what `map_svg` raises."""
    data = base64.b64encode(map_svg(scenario).encode()).decode()
    style = "width:100%;max-width:46rem;background:white"
    return f'<img alt="map of {scenario.name}" style="{style}" src="data:image/svg+xml;base64,{data}">'
