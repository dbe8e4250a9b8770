"""The numbers that planning needs, from a scenario's file or from its models; loads neither planners nor solvers."""

from __future__ import annotations

from drake_ltl.planning.geometry import Geometry
from drake_ltl.scenario.model import Scenario


def planning_geometry(scenario: Scenario) -> Geometry:
    """The numbers planning needs; the models are loaded only if the file leaves some of them out."""
    radii = [member.radius for member in (*scenario.agents, *scenario.objects)]
    radii += [obj.team_radius for obj in scenario.objects]
    if scenario.fits is None or None in radii:
        from drake_ltl.multibody import MeasureGeometry  # loading Drake takes as long as most plans

        return MeasureGeometry(scenario).geometry
    return Geometry(
        agent_radius={agent.name: agent.radius for agent in scenario.agents},
        object_radius={obj.name: obj.radius for obj in scenario.objects},
        object_height={obj.name: 0.0 for obj in scenario.objects},
        team_radius={obj.name: obj.team_radius for obj in scenario.objects},
    )
