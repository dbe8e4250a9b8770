"""Who can reach what is served (this computer alone, unless told otherwise), and who leaves before it has come."""

from __future__ import annotations

import ipaddress
import socket
import struct
import threading
import time
from pathlib import Path

import pytest

from drake_ltl.visualization.live_page import _ADDRESS, live_page
from drake_ltl.visualization.meshcat_scene import MakeMeshcat
from drake_ltl.visualization.page_data import PageData
from drake_ltl.visualization.page_server import PageServer

TABLES = [Path("/proc/net/tcp"), Path("/proc/net/tcp6")]
LISTEN = "0A"

needs_tables = pytest.mark.skipif(not TABLES[0].exists(), reason="Linux alone lists its sockets here")


def listening(port: int) -> list[ipaddress.IPv4Address | ipaddress.IPv6Address]:
    """Addresses at which somebody listens on a port."""
    rows = [row.split() for table in TABLES if table.exists() for row in table.read_text().splitlines()[1:]]
    ends = [row[1].split(":") for row in rows if row[3] == LISTEN]
    return [address(text) for text, number in ends if int(number, 16) == port]


def address(text: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address:
    """Of hexadecimal digits, words of 32 bits in this computer's order (lowest byte first)."""
    words = [bytes.fromhex(text[i : i + 8])[::-1] for i in range(0, len(text), 8)]
    return ipaddress.ip_address(b"".join(words))


@needs_tables
def test_meshcat_listens_on_the_loopback_alone():
    meshcat = MakeMeshcat()
    found = listening(meshcat.port())
    assert found
    assert all(place.is_loopback for place in found)


@needs_tables
def test_pages_are_served_on_the_loopback_alone():
    server = PageServer({})
    found = listening(int(server.url.rstrip("/").rpartition(":")[2]))
    server.close()
    assert found
    assert all(place.is_loopback for place in found)


@needs_tables
@pytest.mark.parametrize("host", ["*", "0.0.0.0"])
def test_everywhere_if_told_so(host):
    """And the tests above would see it."""
    server, meshcat = PageServer({}, host=host), MakeMeshcat(host=host)
    for port in (meshcat.port(), int(server.url.rstrip("/").rpartition(":")[2])):
        found = listening(port)
        assert found
        assert not any(place.is_loopback for place in found)
    server.close()


def test_a_page_connects_to_where_it_comes_from():
    page = live_page(
        f"<body><script>{_ADDRESS}</script></body>", '"http://" + location.hostname + ":7000/"', PageData("t", ())
    )
    assert 'url = "http://" + location.hostname + ":7000/";' in page


def test_who_closes_a_page_before_it_has_come_is_no_error(capfd):
    page, asked = "x" * 10_000_000, threading.Event()  # more than sockets hold, so that it is still on its way

    def source(_: str) -> str:
        asked.set()
        return page

    server = PageServer({"/": source})
    port = int(server.url.rstrip("/").rpartition(":")[2])
    with socket.create_connection(("localhost", port)) as client:
        client.sendall(b"GET / HTTP/1.0\r\n\r\n")
        assert asked.wait(10.0)
        client.recv(100)
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # closed by a reset
    while any("process_request_thread" in thread.name for thread in threading.enumerate()):
        time.sleep(0.01)
    server.close()
    assert capfd.readouterr().err == ""
