"""Types of arguments: what their texts mean, and which are refused."""

from __future__ import annotations

import argparse
import math
import socket
from pathlib import Path


def file_path(text: str) -> Path:
    """The type of an argument that names a file or a folder."""
    if not text.strip():
        raise argparse.ArgumentTypeError("the name is empty")
    return Path(text)


SCENARIO_HELP = "scenario (YAML), or the name of an example"


def scenario_path(text: str) -> Path:
    """The type of an argument that names a scenario: its file, or an example.

    Raises:
        InvalidInputError: there is no such file, nor an example of this name.
    """
    from drake_ltl import examples

    return examples.find(file_path(text))


TIME_LIMIT_HELP = "give up after S seconds of planning"


def seconds(text: str) -> float:
    """The type of an argument that is a time [s]."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < 1e9:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of seconds above 0")
    return value


HOST_HELP = "address of this computer at which others, too, can watch; * for all of its addresses (default: localhost)"


def host(text: str) -> str:
    """An address at which this computer can listen."""
    try:
        socket.create_server(("" if text == "*" else text, 0)).close()
    except (OSError, UnicodeError):
        raise argparse.ArgumentTypeError(f"{text!r} is no address of this computer") from None
    return text
