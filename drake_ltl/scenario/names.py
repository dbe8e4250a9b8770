"""Which names can stand in formulas as they are.

Spot reads a leading upper-case letter as an operator (`Gripper` is G(ripper)), so names are in lower case;
the few lower-case words that it reads otherwise are reserved.
"""

from __future__ import annotations

import re
from typing import Any

from drake_ltl.scenario.table import UnfitValueError, shown

RESERVED = frozenset({"true", "false", "xor", "first_match"})
"""Lower-case words that are constants or operators of Spot's formulas."""

_NAME = re.compile(r"[a-z_][a-z0-9_]*")
_RULE = "lower-case letters, digits and underscores, beginning with a letter or an underscore"


def check_name(name: Any) -> str:
    """`name`, if formulas can name something so; raises UnfitValueError otherwise."""
    if isinstance(name, bool):
        raise UnfitValueError(
            f"the name is not text but {shown(name)}", "choose another: YAML reads true, yes, on and the like so"
        )
    if not isinstance(name, str):
        raise UnfitValueError(f"the name {shown(name)} is not text", f"choose another: {_RULE}")
    if not _NAME.fullmatch(name):
        raise UnfitValueError(f"the name {shown(name)} cannot stand in a formula", f"use {_RULE}")
    if name in RESERVED:
        raise UnfitValueError(f"the name {name!r} is a word of temporal logic", "choose another name")
    return name


def is_name(name: Any) -> bool:
    """Whether formulas can name something so."""
    try:
        check_name(name)
    except UnfitValueError:
        return False
    return True
