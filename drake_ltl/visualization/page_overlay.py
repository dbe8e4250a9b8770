"""What is put into a page of Meshcat's: captions, goals, plan, controls, cameras, names that face the reader.

It asks for nothing outside the page, but a live one for its `status`. Texts, styles and script are files in `pages`.
"""

from __future__ import annotations

import html
import json
from importlib.resources import files

from drake_ltl.visualization.mission_overlay import PATH
from drake_ltl.visualization.page_data import PageData


def with_overlay(page: str, data: PageData) -> str:
    """A Meshcat page with the overlay put in.

    Raises:
        ValueError: it is no such page.
    """
    text = json.dumps(data.to_json() | {"root": PATH.strip("/")}).replace("<", "\\u003c")  # no text can end the script
    script = page_file("mission.js").replace("@DATA@", text)
    overlay = page_file("mission.html").replace("@CSS@", page_file("mission.css")).replace("@JS@", script)
    head, end, tail = page.rpartition("</body>")
    if not end:
        raise ValueError("the page has no </body>: not one that Meshcat returns")
    return _titled(head, data.title) + overlay + end + tail


def page_file(name: str) -> str:
    """A file of the folder `pages`."""
    return (files("drake_ltl.visualization") / "pages" / name).read_text(encoding="utf-8")


def _titled(head: str, title: str) -> str:
    begin, end = head.find("<title>"), head.find("</title>")
    if not title or begin < 0 or end < begin:
        return head
    head = f"{head[:begin]}<title>{html.escape(title)}{head[end:]}"
    return head.replace("<title>", '<meta name="viewport" content="width=device-width, initial-scale=1"><title>', 1)
