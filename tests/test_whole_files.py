"""Files are written whole or not at all."""

from __future__ import annotations

import os
import signal
import stat
import subprocess
import sys

import pytest

from drake_ltl import whole_files
from drake_ltl.whole_files import write_text_whole, written_whole


@pytest.fixture(params=["nameless", "named"])
def either_way(request, monkeypatch) -> None:
    """Also on file systems on which a file needs a name."""
    if request.param == "named":
        monkeypatch.delattr(os, "O_TMPFILE", raising=False)


def test_new_files_and_old_ones(tmp_path, either_way):
    path = tmp_path / "file"
    write_text_whole(path, "é")
    assert path.read_bytes() == "é".encode()
    assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~whole_files._UMASK
    path.chmod(0o640)
    write_text_whole(path, "new")
    assert path.read_text(encoding="utf-8") == "new"
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
def test_nothing_is_left_of_what_fails(tmp_path, either_way, error):
    path = tmp_path / "file"

    def fail() -> None:
        with written_whole(path) as file:
            file.write(b"half")
            raise error

    for _ in range(2):
        with pytest.raises(error):
            fail()
        assert [p.name for p in tmp_path.iterdir()] == (["file"] if path.exists() else [])
        path.write_text("precious", encoding="utf-8")
    assert path.read_text(encoding="utf-8") == "precious"


def test_links_lead_to_what_is_replaced(tmp_path, either_way):
    (tmp_path / "link").symlink_to(tmp_path / "target")
    write_text_whole(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "target").read_text(encoding="utf-8") == "new"


def test_what_is_no_plain_file_is_written_as_it_is(tmp_path):
    write_text_whole("/dev/null", "nothing")
    assert os.path.exists("/dev/null")
    assert not os.path.isfile("/dev/null")
    with pytest.raises(OSError, match="No space left"):
        write_text_whole("/dev/full", "x")


def test_a_folder_in_which_nothing_can_be_made(tmp_path, monkeypatch):
    path = tmp_path / "file"
    path.write_text("old", encoding="utf-8")
    monkeypatch.setattr(os, "access", lambda *_: False)
    write_text_whole(path, "new")
    assert path.read_text(encoding="utf-8") == "new"


WRITING = """
import os, sys
from drake_ltl.whole_files import written_whole
with written_whole(sys.argv[1]) as file:
    file.write(b"x" * 100_000)
    file.flush()
    {end}
"""


def test_a_program_that_is_killed_leaves_nothing(tmp_path):
    path = tmp_path / "file"
    path.write_text("precious", encoding="utf-8")
    program = WRITING.format(end="os.kill(os.getpid(), 9)")
    done = subprocess.run([sys.executable, "-c", program, path], check=False)
    assert done.returncode == -signal.SIGKILL
    assert path.read_text(encoding="utf-8") == "precious"
    assert list(tmp_path.iterdir()) == [path]


def test_a_disk_that_is_full(tmp_path):
    """As `ulimit -f` makes it: the file may have 50 kB."""
    path = tmp_path / "file"
    path.write_text("precious", encoding="utf-8")
    limit = "import resource, signal\nsignal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
    limit += "resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))\n"
    program = limit + WRITING.format(end="pass")
    done = subprocess.run([sys.executable, "-c", program, path], capture_output=True, text=True, check=False)
    assert "File too large" in done.stderr
    assert path.read_text(encoding="utf-8") == "precious"
    assert list(tmp_path.iterdir()) == [path]
