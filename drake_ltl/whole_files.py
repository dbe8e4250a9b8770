"""Files that are there whole or not at all, whatever ends the program that writes them."""

from __future__ import annotations

import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

_UMASK = os.umask(0o077)  # it can only be read by setting it
os.umask(_UMASK)


@contextmanager
def written_whole(path: Path | str) -> Iterator[BinaryIO]:
    """A file for writing, which takes the place of `path` when the body ends, and leaves it as it was if it fails.

    On Linux it has no name until then: even a program that is killed leaves nothing behind. Links are followed. What
    is no plain file (a pipe, /dev/stdout), or stands in a folder in which nothing can be made, is written as it is.

    Raises:
        OSError: it cannot be written; a full disk shows here, before anything is replaced.
    """
    place = Path(os.path.realpath(path))
    if (place.exists() and not place.is_file()) or not os.access(place.parent, os.W_OK):
        with place.open("wb") as file:
            yield file
        return
    mode = stat.S_IMODE(place.stat().st_mode) if place.exists() else 0o666 & ~_UMASK
    descriptor, temporary = _open(place)
    try:
        with os.fdopen(descriptor, "wb") as file:
            yield file
            file.flush()
            os.fchmod(file.fileno(), mode)
            temporary = temporary or _name(file.fileno(), place)
        os.replace(temporary, place)
    except BaseException:
        if temporary is not None:
            with suppress(FileNotFoundError):
                os.unlink(temporary)
        raise


def write_text_whole(path: Path | str, text: str) -> None:
    """`Path.write_text` in UTF-8, whole or not at all. Raises OSError if it cannot."""
    with written_whole(path) as file:
        file.write(text.encode())


def _open(place: Path) -> tuple[int, str | None]:
    """A file in the folder of `place`: without a name if the system can do that, else with a temporary one."""
    if hasattr(os, "O_TMPFILE"):
        with suppress(OSError):  # not all file systems can
            return os.open(place.parent, os.O_TMPFILE | os.O_WRONLY, 0o600), None
    return tempfile.mkstemp(dir=place.parent, prefix=f".{place.name[:100]}.")


def _name(descriptor: int, place: Path) -> str:
    """Gives a file without a name a temporary one: a name that is taken cannot be given directly."""
    temporary = tempfile.mktemp(dir=place.parent, prefix=f".{place.name[:100]}.")
    open_files = os.open("/proc/self/fd", os.O_RDONLY)
    try:  # only with a folder does Python ask for the file that the entry leads to
        os.link(str(descriptor), temporary, src_dir_fd=open_files, follow_symlinks=True)
    finally:
        os.close(open_files)
    return temporary
