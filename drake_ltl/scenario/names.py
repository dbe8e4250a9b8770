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


def check_name(name: Any) -> str:
    """`name`, if formulas can name something so; raises UnfitValueError otherwise."""
    if not isinstance(name, str):
        raise UnfitValueError(f"the name {shown(name)} is not text", "put it in quotes or change it")
    if not _NAME.fullmatch(name):
        raise UnfitValueError(
            f"the name {shown(name)} cannot stand in a formula",
            "use lower-case letters, digits and underscores, beginning with a letter or an underscore",
        )
    if name in RESERVED:
        raise UnfitValueError(f"the name {name!r} is a word of temporal logic", "choose another name")
    return name
