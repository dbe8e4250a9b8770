"""A recorded mission as one HTML file: the scene that plays, with captions, a clock and the steps to jump to."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping, Sequence
from pathlib import Path

from pydrake.geometry import Meshcat

from drake_ltl.errors import naming_file
from drake_ltl.execution.recording import Recording
from drake_ltl.visualization.mission_overlay import PATH, PUBLISH_PERIOD
from drake_ltl.visualization.page_overlay import OVERLAY
from drake_ltl.visualization.palette import hex_code, member_colours
from drake_ltl.visualization.words import actions_words, step_heading

Caption = tuple[float, str]
"""When it begins [s], and its lines: the first is a heading."""


def StartPage(meshcat: Meshcat, *, live: bool = False) -> None:
    """Call it before the run: what is published from now on is recorded.

    Args:
        live: whether browsers that are connected see the run as well (which takes more time).
    """
    meshcat.StartRecording(1 / PUBLISH_PERIOD, set_visualizations_while_recording=live)


def WritePage(
    meshcat: Meshcat,
    path: Path | str,
    captions: Sequence[Caption],
    *,
    title: str = "",
    legend: Mapping[str, str] | None = None,
) -> Path:
    """Call it after the run: writes one HTML file that needs no network, and stops the recording.

    Args:
        captions: in order of their begin; see `captions_of`.
        legend: name -> CSS colour; see `legend_of`.

    Raises:
        OSError: the file cannot be written.
    """
    meshcat.StopRecording()
    meshcat.PublishRecording()
    page = with_overlay(meshcat.StaticHtml(), captions, title=title, legend=legend or {})
    path = Path(path)
    with naming_file(path):
        path.write_text(page, encoding="utf-8")
    return path


def captions_of(recording: Recording) -> list[Caption]:
    """A caption for each step of a run, and one for its end."""
    captions = [
        (step.start, "\n".join([step_heading(step, recording), *actions_words(step.actions)]))
        for step in recording.steps
    ]
    if len(recording.time) and recording.steps:
        last = recording.steps[-1]
        text = "All steps done" if recording.completed else f"Stopped\n{recording.reason}"
        captions.append((last.start + last.duration, text))
    return captions


def legend_of(recording: Recording) -> dict[str, str]:
    """Name -> CSS colour of all members."""
    colours = member_colours(recording.agents, recording.objects)
    return {name: hex_code(colour) for name, colour in colours.items()}


def with_overlay(
    page: str, captions: Sequence[Caption], *, title: str = "", legend: Mapping[str, str] | None = None
) -> str:
    """An exported Meshcat page with the overlay put in; it reads the time of the page's own animation."""
    data = {
        "captions": [[begin, text.split("\n")] for begin, text in captions],
        "legend": list((legend or {}).items()),
        "title": title,
        "root": PATH.strip("/"),
    }
    text = json.dumps(data).replace("<", "\\u003c")  # no text can end the script
    overlay = OVERLAY.replace("@DATA@", text)
    head, end, tail = page.rpartition("</body>")
    if not end:
        raise ValueError("the page has no </body>: not one that Meshcat.StaticHtml returns")
    return _titled(head, title) + overlay + end + tail


def _titled(head: str, title: str) -> str:
    begin, end = head.find("<title>"), head.find("</title>")
    if not title or begin < 0 or end < begin:
        return head
    return f"{head[:begin]}<title>{html.escape(title)}{head[end:]}"
