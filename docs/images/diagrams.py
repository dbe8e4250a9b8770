"""Draws the diagrams of systems in docs/architecture.md: python docs/images/diagrams.py (needs Graphviz)."""

from __future__ import annotations

from pathlib import Path

from drake_ltl.diagrams import MakeMissionDiagram

from drake_ltl.mission import measure, num_steps, plan_and_place, write_graphviz
from drake_ltl.scenario import load

HERE = Path(__file__).parent
SCENARIO = HERE.parents[1] / "examples" / "patrol.yaml"


def make(separate: bool):
    """The mission's diagram, without the monitors: they are many, and all read what they watch."""
    scenario = load(SCENARIO)
    models = measure(scenario)
    mission = plan_and_place(scenario, models)
    steps = num_steps(mission, 1)
    made = MakeMissionDiagram(mission, scenario, models, num_steps=steps, separate_controllers=separate, monitors=False)
    return made.diagram


def main() -> None:
    write_graphviz(make(separate=False), HERE / "diagram.svg")
    write_graphviz(make(separate=True), HERE / "diagram_separate.svg")


if __name__ == "__main__":
    main()
