"""`drake-ltl completion SHELL`: a script that lets a shell complete commands, options and files."""

from __future__ import annotations

import argparse

from drake_ltl.cli.statuses import SUCCESS

SHELLS = ("bash", "zsh", "fish")


def add_parser(commands: argparse._SubParsersAction) -> None:
    """Adds the command to the parser."""
    parser = commands.add_parser(
        "completion",
        help="print a script that completes commands in a shell",
        description="Prints a script for a shell's completion of commands, options and files. bash: put the example's "
        "line into ~/.bashrc; zsh: write the script to a file _drake-ltl in a folder of $fpath; fish: write it to "
        "~/.config/fish/completions/drake-ltl.fish.",
        epilog='example: eval "$(drake-ltl completion bash)"',
    )
    parser.add_argument("shell", choices=SHELLS, metavar="SHELL", help="bash, zsh or fish")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Prints the script, made from the parser itself."""
    from drake_ltl.cli import make_parser
    from drake_ltl.cli.completion_scripts import script

    print(script(args.shell, make_parser()))
    return SUCCESS
