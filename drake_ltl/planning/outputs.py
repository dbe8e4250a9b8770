"""All symbolic outputs of a plan as files."""

from __future__ import annotations

import io
import json
from pathlib import Path

from rich.console import Console

from drake_ltl.planning.graphs import automaton_hoa, plan_dot
from drake_ltl.planning.plan import Plan
from drake_ltl.planning.plan_json import plan_to_json
from drake_ltl.planning.projections import project_all, projections_to_json
from drake_ltl.planning.table import plan_table
from drake_ltl.scenario.model import Scenario
from drake_ltl.whole_files import write_text_whole

TABLE_WIDTH = 120
"""Columns of the action table."""


def write_outputs(plan: Plan, scenario: Scenario, directory: Path) -> tuple[Path, ...]:
    """Write what a plan says into a folder, which is made if it is not there.

    - `plan.json`: states, actions, costs, counts (`plan_json`)
    - `plan.txt`: the table of actions, and each member's way
    - `plan.dot`: the lasso, for Graphviz
    - `projections.json`: regions, grasps and letters of each member
    - `automaton.hoa`: the automaton of the global formula

    Returns:
        The files.
    """
    texts = {
        "plan.json": _json(plan_to_json(plan, scenario)),
        "plan.txt": _text(plan, scenario),
        "plan.dot": plan_dot(plan, scenario),
        "projections.json": _json(projections_to_json(plan, scenario)),
        "automaton.hoa": automaton_hoa(scenario),
    }
    directory.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        write_text_whole(directory / name, text)
    return tuple(directory / name for name in texts)


def _json(data: object) -> str:
    return json.dumps(data, indent=2, allow_nan=False) + "\n"


def _text(plan: Plan, scenario: Scenario) -> str:
    file = io.StringIO()
    Console(file=file, width=TABLE_WIDTH).print(plan_table(plan, scenario))
    table = "\n".join(line.rstrip() for line in file.getvalue().replace("\N{NO-BREAK SPACE}", " ").splitlines())
    return "\n".join([table, "", *map(str, project_all(plan, scenario))]) + "\n"
