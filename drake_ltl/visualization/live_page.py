"""A page that shows a mission while it runs: Meshcat's own page with the overlay, served beside it."""

from __future__ import annotations

import urllib.request
from collections.abc import Callable, Mapping
from typing import Any

from pydrake.geometry import Meshcat

from drake_ltl.errors import ExecutionError
from drake_ltl.visualization.meshcat_scene import LOCALHOST
from drake_ltl.visualization.page_data import PageData
from drake_ltl.visualization.page_overlay import with_overlay
from drake_ltl.visualization.page_server import PATIENCE, PageServer

_ADDRESS = "url = location.toString();"
"""Where Meshcat's page works out whom to connect to."""


def ServeLivePage(
    meshcat: Meshcat, data: PageData, status: Callable[[str], Mapping[str, Any]], host: str = LOCALHOST
) -> PageServer:
    """Serves the page at `.url` of what is returned.

    Args:
        status: makes what the page asks for ten times a second, and is told the simulated time [s] that its scene
            shows; called from another thread.
        host: the one of `meshcat`, see `MakeMeshcat`.

    Raises:
        ExecutionError: Meshcat's page is not as Drake's releases have it.
    """
    url = meshcat.web_url()
    where = f'"{url}/"' if host == LOCALHOST else f'"http://" + location.hostname + ":{meshcat.port()}/"'
    page = live_page(_page_of(url), where, data)
    return PageServer({"/": lambda _: page, "/status": status}, behind=url, host=host)


def live_page(page: str, where: str, data: PageData) -> str:
    """Meshcat's page, such that it can be served elsewhere, with the overlay.

    Args:
        where: expression of JavaScript for Meshcat's address.

    Raises:
        ExecutionError: it is not as Drake's releases have it.
    """
    if page.count(_ADDRESS) != 1:
        raise ExecutionError("Meshcat's page is not as expected: use a release of Drake that pyproject.toml allows")
    return with_overlay(page.replace(_ADDRESS, f"url = {where};"), data)


def _page_of(url: str) -> str:
    with urllib.request.urlopen(f"{url}/", timeout=PATIENCE) as answer:
        return answer.read().decode("utf-8")
