"""How figures look, and how they are written: Matplotlib's Agg, no display, no global state."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from drake_ltl.errors import naming_file
from drake_ltl.visualization.palette import INK, MUTED
from drake_ltl.whole_files import written_whole

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


@dataclass(frozen=True)
class Drawing:
    """A figure as a function of data, to be written in any format."""

    name: str
    """Of its files, without suffix."""
    title: str
    """What it shows, for those who do not see it and as a caption."""
    size: tuple[float, float]
    """Width and height [inches]."""
    draw: Callable[[Figure], None]

    def write(self, directory: Path, formats: Sequence[str]) -> list[Path]:
        """Writes name.png, name.svg, ... (OSError if it cannot)."""
        return write_figure(self.draw, self.size, Path(directory) / self.name, formats)

    def render(self, formats: Sequence[str]) -> dict[str, bytes]:
        """Format -> the file's content; drawn once, which takes most of the time.

        Args:
            formats: of `png`, `svg`, `pdf` and `page`, an SVG with outlines for letters: it looks the same everywhere.
        """
        with mpl.rc_context(RC):
            figure = Figure(figsize=self.size, layout="constrained")
            self.draw(figure)
            figure.draw_without_rendering()
            figure.set_layout_engine("none")  # as it is now, for all formats
            return {kind: _saved(figure, kind) for kind in formats}

    def svg(self) -> str:
        """For pages."""
        return self.render(["page"])["page"].decode()


def _saved(figure: Figure, kind: str) -> bytes:
    stream, suffix = io.BytesIO(), "svg" if kind == "page" else kind
    with mpl.rc_context({"svg.fonttype": "path"} if kind == "page" else {}):
        figure.savefig(stream, format=suffix, metadata=_UNDATED.get(suffix))
    return stream.getvalue()


def write_figure(
    draw: Callable[[Figure], None], size: tuple[float, float], stem: Path, formats: Sequence[str]
) -> list[Path]:
    """Lets `draw` fill a figure of `size` inches and writes it as stem.png, stem.svg, ... (OSError if it cannot)."""
    contents = Drawing(stem.name, "", size, draw).render(formats)
    paths = [stem.with_name(f"{stem.name}.{suffix}") for suffix in formats]
    for content, path in zip(contents.values(), paths, strict=True):
        with naming_file(path), written_whole(path) as file:
            file.write(content)
    return paths
