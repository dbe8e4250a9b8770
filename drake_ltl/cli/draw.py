"""`drake-ltl draw FILE`: a map of a scenario at its start."""

from __future__ import annotations

import argparse
from pathlib import Path

from drake_ltl.cli.arguments import SCENARIO_HELP, file_path, scenario_path
from drake_ltl.cli.outcome import check_writable, say_written, silence_matplotlib, working
from drake_ltl.cli.starting import measured_models
from drake_ltl.cli.statuses import SUCCESS

FORMATS = ("png", "svg", "pdf")


def add_parser(commands: argparse._SubParsersAction) -> None:
    """Adds the command to the parser."""
    parser = commands.add_parser(
        "draw",
        help="draw a map of a scenario",
        description="Draws the workspace from above: regions with their names, robots and objects where they start, "
        "with their bounding spheres, and everybody's formula.",
        epilog="example: drake-ltl draw warehouse --output warehouse.svg",
    )
    parser.add_argument("file", type=scenario_path, metavar="FILE", help=SCENARIO_HELP)
    parser.add_argument(
        "--output",
        type=_picture,
        default=Path("map.png"),
        metavar="OUT",
        help="the picture: .png, .svg or .pdf (default: map.png)",
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Draws the map; nothing is planned."""
    check_writable(args.output, source=args.file)
    silence_matplotlib()
    from drake_ltl.scenario import load

    scenario = load(args.file)
    geometry = measured_models(scenario).geometry
    with working("drawing"):
        from drake_ltl.scenario.starts import check_starts
        from drake_ltl.visualization.scenario_map import draw_map

        draw_map(scenario, geometry, check_starts(scenario, geometry), args.output)
    say_written(args.output)
    return SUCCESS


def _picture(text: str) -> Path:
    path = file_path(text)
    if path.suffix.lstrip(".") not in FORMATS:
        raise argparse.ArgumentTypeError(f"{text!r} does not end in {', '.join('.' + kind for kind in FORMATS)}")
    return path
