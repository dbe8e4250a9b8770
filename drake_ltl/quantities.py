"""Measured numbers for people."""

from __future__ import annotations

import math


def quantity(value: float, unit: str) -> str:
    """With its unit: millimetres below a centimetre, degrees for angles."""
    if unit == "m" and abs(value) < 0.01:
        return f"{1e3 * value:.3g} mm"
    if unit == "rad":
        return f"{math.degrees(value):.3g} degrees"
    return f"{value:.3g} {unit}".rstrip()
