"""A recorded mission as one HTML file: the scene that plays, with captions, controls and the steps to jump to."""

from __future__ import annotations

from pathlib import Path

from pydrake.geometry import Meshcat

from drake_ltl.errors import naming_file
from drake_ltl.visualization.mission_overlay import PUBLISH_PERIOD
from drake_ltl.visualization.page_data import PageData
from drake_ltl.visualization.page_overlay import with_overlay
from drake_ltl.whole_files import write_text_whole


def StartPage(meshcat: Meshcat, *, live: bool = False) -> None:
    """Call it before the run: what is published from now on is recorded.

    Args:
        live: whether browsers that are connected see the run as well (which takes more time).
    """
    meshcat.StartRecording(1 / PUBLISH_PERIOD, set_visualizations_while_recording=live)


def MakePage(meshcat: Meshcat, data: PageData) -> str:
    """Call it after the run: one HTML page that needs no network; it stops the recording."""
    meshcat.StopRecording()
    meshcat.PublishRecording()
    return with_overlay(meshcat.StaticHtml(), data)


def WritePage(meshcat: Meshcat, path: Path | str, data: PageData) -> Path:
    """Writes what MakePage makes.

    Raises:
        OSError: the file cannot be written.
    """
    path = Path(path)
    with naming_file(path):
        write_text_whole(path, MakePage(meshcat, data))
    return path
