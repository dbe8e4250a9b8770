"""How figures look, and how they are written: Matplotlib's Agg, no display, no global state."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from drake_ltl.errors import naming_file
from drake_ltl.visualization.palette import INK, MUTED

RC = {
    "font.family": "DejaVu Sans",  # comes with Matplotlib: the same everywhere
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.labelsize": 9.0,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "lines.linewidth": 1.6,
    "lines.solid_capstyle": "round",
    "savefig.dpi": 160,
    "pdf.fonttype": 42,  # text stays text
    "svg.fonttype": "none",
    "svg.hashsalt": "drake_ltl",  # the same recording gives the same file
}
HALO = [withStroke(linewidth=2.5, foreground="white", alpha=0.85)]
"""Keeps text readable on lines."""
_UNDATED = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}


def write_figure(
    draw: Callable[[Figure], None], size: tuple[float, float], stem: Path, formats: Sequence[str]
) -> list[Path]:
    """Lets `draw` fill a figure of `size` inches and writes it as stem.png, stem.svg, ... (OSError if it cannot)."""
    paths = [stem.with_name(f"{stem.name}.{suffix}") for suffix in formats]
    with mpl.rc_context(RC):
        figure = Figure(figsize=size, layout="constrained")
        draw(figure)
        for suffix, path in zip(formats, paths, strict=True):
            with naming_file(path):
                figure.savefig(path, format=suffix, metadata=_UNDATED.get(suffix))
    return paths
