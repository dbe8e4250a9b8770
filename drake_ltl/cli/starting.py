"""A scenario's models and starts, refused before what plans and simulates is loaded, which takes longer."""

from __future__ import annotations

from typing import TYPE_CHECKING

from drake_ltl.cli.outcome import working
from drake_ltl.scenario.model import Scenario

if TYPE_CHECKING:
    from drake_ltl.multibody import MeasuredModels
    from drake_ltl.planning.geometry import Geometry


def measured_models(scenario: Scenario) -> MeasuredModels:
    """Raises InvalidInputError for a model that cannot be used, and for bodies that start where they may not."""
    with working("loading the models"):
        from drake_ltl.multibody import MeasureGeometry
        from drake_ltl.scenario.starts import check_starts

        models = MeasureGeometry(scenario)
        check_starts(scenario, models.geometry)
    return models


def measured_geometry(scenario: Scenario) -> Geometry:
    """The same for plans alone, which need no models where the file has all numbers."""
    with working("loading the models"):
        from drake_ltl.planning_geometry import planning_geometry
        from drake_ltl.scenario.starts import check_starts

        geometry = planning_geometry(scenario)
        check_starts(scenario, geometry)
    return geometry
