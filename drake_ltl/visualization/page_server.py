"""Serves a few pages to browsers on this computer."""

from __future__ import annotations

import http.server
import json
import socket
import threading
import urllib.request
from collections.abc import Callable, Mapping
from contextlib import suppress
from http import HTTPStatus
from typing import Any

Source = Callable[[str], "str | Mapping[str, Any]"]
"""Makes what is served, HTML or data for JSON, of what follows the `?` in the address."""

PORTS = range(7700, 7720)
"""Preferred, so that people find pages, and can forward the port, where they were the last time."""
PATIENCE = 30.0
"""For files of another server [s]."""


class PageServer:
    """Answers on a free port of this computer, in a thread of its own that ends with the process."""

    def __init__(self, sources: Mapping[str, Source], behind: str = "", host: str = "localhost"):
        """What is served.

        Args:
            sources: path, such as `/`, -> what is there.
            behind: address of the server on this computer that has all other files; empty if there is none.
            host: address to listen at, "*" for all of this computer's.
        """
        handler = type("Handler", (_Handler,), {"sources": dict(sources), "behind": behind})
        self._server = _listening("" if host == "*" else host, handler)
        self._host = host
        self._server.daemon_threads = True
        threading.Thread(target=self._server.serve_forever, name="page server", daemon=True).start()

    @property
    def url(self) -> str:
        """Where the pages are."""
        name = socket.gethostname() if self._host in ("*", "0.0.0.0", "::") else self._host
        return f"http://{name}:{self._server.server_port}/"

    def close(self) -> None:
        """Answers no more."""
        self._server.shutdown()
        self._server.server_close()


def _listening(host: str, handler: type[_Handler]) -> http.server.ThreadingHTTPServer:
    """On the first of PORTS that nobody has, else on any."""
    for port in PORTS:
        with suppress(OSError):
            return http.server.ThreadingHTTPServer((host, port), handler)
    return http.server.ThreadingHTTPServer((host, 0), handler)


class _Handler(http.server.BaseHTTPRequestHandler):
    sources: Mapping[str, Source]
    behind: str

    def handle(self) -> None:
        """Whoever has closed the page does not wait for an answer."""
        with suppress(ConnectionError):
            super().handle()

    def do_GET(self) -> None:
        path, _, query = self.path.partition("?")
        source = self.sources.get(path)
        if self.path == "/favicon.ico":
            return self._send(HTTPStatus.NO_CONTENT, "image/x-icon", b"")
        if source is None:
            return self._send(*self._fetched())
        content = source(query)
        if isinstance(content, str):
            return self._send(HTTPStatus.OK, "text/html; charset=utf-8", content.encode())
        return self._send(HTTPStatus.OK, "application/json", json.dumps(content).encode())

    def _fetched(self) -> tuple[HTTPStatus, str, bytes]:
        """From the server behind."""
        try:
            if self.behind:
                with urllib.request.urlopen(self.behind + self.path, timeout=PATIENCE) as answer:
                    return HTTPStatus.OK, answer.headers.get("Content-Type", ""), answer.read()
        except OSError:
            pass
        return HTTPStatus.NOT_FOUND, "text/plain", b"there is no such page\n"

    def _send(self, status: HTTPStatus, kind: str, body: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        """Nobody wants to read of every request."""
