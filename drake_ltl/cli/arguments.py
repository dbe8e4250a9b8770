"""Types of arguments: what their texts mean, and which are refused."""

from __future__ import annotations

import argparse
import math
import socket
from collections.abc import Callable
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


def whole(least: int, most: int) -> Callable[[str], int]:
    """The type of an argument that is a whole number."""

    def read(text: str) -> int:
        if not (text.isascii() and text.isdigit() and len(text) < 20 and least <= int(text) <= most):
            raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from {least} to {most}")
        return int(text)

    return read


def number(least: float, most: float, what: str = "number") -> Callable[[str], float]:
    """The type of an argument that is a number, `what` it is for people."""

    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not least <= value <= most:
            raise argparse.ArgumentTypeError(f"{text!r} is not a {what} from {least:g} to {most:g}")
        return value

    return read


SUFFIX_ROUNDS = whole(1, 100_000)
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
