"""`drake-ltl check FILE`: every mistake of a scenario, without planning."""

from __future__ import annotations

import argparse

from drake_ltl.cli.arguments import SCENARIO_HELP, scenario_path
from drake_ltl.cli.outcome import console
from drake_ltl.cli.starting import measured_models
from drake_ltl.cli.statuses import SUCCESS


def add_parser(commands: argparse._SubParsersAction) -> None:
    """Adds the command to the parser."""
    parser = commands.add_parser(
        "check",
        help="look for mistakes in a scenario",
        description="Reads a scenario, loads its models and looks where everybody starts. Prints one line per mistake: "
        "where it is, what is wrong, what would be right. Exit status: 0 no mistakes, 2 mistakes.",
        epilog="example: drake-ltl check warehouse",
    )
    parser.add_argument("file", type=scenario_path, metavar="FILE", help=SCENARIO_HELP)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """0 if nothing is wrong.

    Raises:
        InvalidInputError: with every mistake of the file; of a sound file, with all that its models or starts have.
    """
    from drake_ltl.scenario import load

    scenario = load(args.file)
    measured_models(scenario)
    counts = ((scenario.regions, "region"), (scenario.agents, "agent"), (scenario.objects, "object"))
    parts = ", ".join(f"{len(members)} {kind}{'' if len(members) == 1 else 's'}" for members, kind in counts)
    console().print(f"no mistakes found: {parts}", highlight=False)
    for agent in scenario.agents:
        if not agent.has_arm:
            says = f"{agent.name} is a differential drive without an arm: it may travel, but not grasp or carry"
            console().print(says, highlight=False, soft_wrap=True)
    return SUCCESS
