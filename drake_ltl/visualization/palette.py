"""One set of colours for the page and the figures, told apart by colour-blind eyes too.

Agents take the colours of Okabe and Ito (2008), objects dark earthy ones; beyond these the same hues return darker,
then lighter. Everything carries its name besides: colour is never the only sign.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

Colour = tuple[float, float, float]
"""Red, green and blue in [0, 1]."""


def _rgb(code: str) -> Colour:
    return tuple(int(code[i : i + 2], 16) / 255 for i in (1, 3, 5))


AGENT_HUES = tuple(map(_rgb, ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")))
OBJECT_HUES = tuple(map(_rgb, ("#7A4A10", "#7A1F4F", "#5C6B7A", "#8A8A1A")))

INK = _rgb("#22282E")
"""Text and outlines."""
MUTED = _rgb("#7A838C")
"""Text and lines that step back."""
GRID = _rgb("#D3D9DE")
REGION = _rgb("#8FA6BC")
"""Regions: discs and balls."""
FLOOR = _rgb("#F3F5F7")
SKY_TOP = _rgb("#C9D6E2")
SKY_BOTTOM = _rgb("#FBFCFD")
DANGER = _rgb("#B00020")
"""Where a clearance is negative."""


def agent_colours(names: Sequence[str]) -> dict[str, Colour]:
    """A colour for each agent, by its place in the scenario."""
    return {name: _shade(AGENT_HUES, index) for index, name in enumerate(names)}


def object_colours(names: Sequence[str]) -> dict[str, Colour]:
    """A colour for each object, by its place in the scenario."""
    return {name: _shade(OBJECT_HUES, index) for index, name in enumerate(names)}


def member_colours(agents: Sequence[str], objects: Sequence[str]) -> Mapping[str, Colour]:
    """Colours of all members by name."""
    return agent_colours(agents) | object_colours(objects)


def mixed(colour: Colour, other: Colour, amount: float) -> Colour:
    """`colour` with the share `amount` in [0, 1] of `other`."""
    return tuple((1 - amount) * a + amount * b for a, b in zip(colour, other, strict=True))


def hex_code(colour: Colour) -> str:
    """As in CSS: #rrggbb."""
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in colour)


def _shade(hues: Sequence[Colour], index: int) -> Colour:
    """The hue, and in each later round of the list the same hue darker or lighter."""
    rounds, place = divmod(index, len(hues))
    amount = 1 - 0.6 ** ((rounds + 1) // 2)
    towards = (0.0, 0.0, 0.0) if rounds % 2 else (1.0, 1.0, 1.0)
    return mixed(hues[place], towards, amount)
