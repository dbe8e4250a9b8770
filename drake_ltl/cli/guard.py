"""Runs a command in a child process, so that it can be ended at any moment, whichever library it is in.

Python acts on signals between its own instructions only: Spot, the solvers and Drake hold it up while they compute or
load. The guard, which computes nothing, hears Ctrl-C, SIGTERM and the end of the time, and ends the command. The
command tells it by notes through a pipe what to do then: whether there is something to save, and what to write when
time is over. Without a guard (`main` called from Python) notes go nowhere.
"""

from __future__ import annotations

import json
import os
import select
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from drake_ltl.cli.statuses import BAD_INPUT, FAILURE, INTERRUPTED
from drake_ltl.processes import adopt, bury, fork
from drake_ltl.whole_files import write_text_whole

GRACE = 0.5
"""How much longer than its own time limit the command is given to obey it by itself [s]."""

_STOPS = (signal.SIGINT, signal.SIGTERM)
_SAVE = signal.SIGUSR1
"""What the guard sends to a command that has something to save; Ctrl-C reaches the command as well, and is ignored."""

_notes: int | None = None
"""The command's end of the pipe."""


def guarded(command: Callable[[], int]) -> int:
    """The exit status of a command. Returns in the command's process alone: the guard's ends here, with that status."""
    global _notes
    reading, writing = os.pipe()
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {*_STOPS, _SAVE})
    child = fork()
    if child:
        os.close(writing)
        os._exit(_Guard(child, reading).wait(mask))  # it has nothing of its own to put in order
    os.close(reading)
    _notes = writing
    for stop in _STOPS:
        signal.signal(stop, signal.SIG_IGN)
    signal.signal(_SAVE, signal.default_int_handler)
    signal.pthread_sigmask(signal.SIG_SETMASK, mask)
    return command()


def save_when_interrupted() -> None:
    """From now on the first interruption raises KeyboardInterrupt in the command, and only the second ends it."""
    _tell(saves=True)


@contextmanager
def at_the_latest(seconds: float | None, complaint: str, path: object = None, text: str = "") -> Iterator[None]:
    """Should the body last longer than so many seconds, the command is ended and counts as failed.

    Args:
        complaint: then goes to stderr, unless it is empty.
        path: a file that then gets the text, unless it is None.
    """
    if seconds is None:
        yield
        return
    _tell(limit={"seconds": seconds, "complaint": complaint, "path": path and os.fspath(path), "text": text})
    try:
        yield
    finally:
        _tell(limit=None)


def _tell(**note: Any) -> None:
    if _notes is not None:
        with suppress(BrokenPipeError):
            os.write(_notes, json.dumps(note).encode() + b"\n")


class _Guard:
    """Waits for a command's process, for signals and for the end of the time."""

    def __init__(self, child: int, notes: int):
        self._child, self._notes = child, notes
        self._unread = b""
        self._saves = False
        self._limit: dict[str, Any] | None = None
        self._end = 0.0

    def wait(self, mask: set[signal.Signals]) -> int:
        """The command's exit status, or what it is in its place."""
        signals, wake = os.pipe()
        os.set_blocking(wake, False)
        signal.set_wakeup_fd(wake)
        for stop in _STOPS:
            if signal.getsignal(stop) is not signal.SIG_IGN:  # as nohup and shells' background jobs have it
                signal.signal(stop, lambda *_: None)
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        while True:
            left = None if self._limit is None else max(0.0, self._end - time.monotonic())
            ready = select.select([self._notes, signals], [], [], left)[0]
            if self._notes in ready and not self._hear():
                return self._ended()
            if signals in ready:
                os.read(signals, 64)
                if not self._saves:
                    return self._interrupt()
                self._saves = False
                os.kill(self._child, _SAVE)
            if not ready:
                return self._time_is_over()

    def _hear(self) -> bool:
        """Take down what the command tells; False if it has ended."""
        data = os.read(self._notes, 1 << 16)
        *notes, self._unread = (self._unread + data).split(b"\n")
        for note in map(json.loads, notes):
            self._saves = note.get("saves", self._saves)
            if "limit" in note:
                self._limit = note["limit"]
                self._end = time.monotonic() + GRACE + (self._limit["seconds"] if self._limit else 0.0)
        return bool(data)

    def _ended(self) -> int:
        code = os.waitstatus_to_exitcode(os.waitpid(self._child, 0)[1])
        if code >= 0:
            return code
        name = signal.Signals(-code).name
        reason = f"ended by {name}" + ("; perhaps memory was short" if -code == signal.SIGKILL else "")
        return self._fail(f"no result: {reason}") if self._limit else _complain(reason, 128 - code)

    def _interrupt(self) -> int:
        self._kill()
        return _complain("interrupted", INTERRUPTED)

    def _time_is_over(self) -> int:
        self._kill()
        return self._fail(self._limit["complaint"])

    def _fail(self, complaint: str) -> int:
        """What the command would have done, had it found nothing."""
        path, text = self._limit["path"], self._limit["text"]
        if complaint:
            _complain(complaint, FAILURE)
        if path is None:
            return FAILURE
        try:
            write_text_whole(path, text)
        except OSError as error:
            return _complain(f"{path}: {error.strerror}", BAD_INPUT)
        return FAILURE

    def _kill(self) -> None:
        adopt()
        os.kill(self._child, signal.SIGKILL)
        bury(GRACE)
        if os.isatty(2):
            _write("\r\x1b[2K\x1b[?25h")  # the command may have been showing its progress, without a cursor


def _complain(text: str, status: int) -> int:
    _write(f"{text}\n")
    return status


def _write(text: str) -> None:
    with suppress(OSError):
        os.write(2, text.encode(sys.getfilesystemencoding(), "replace"))
