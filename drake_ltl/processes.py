"""Child processes that can be ended at any moment, for work in libraries that do not listen while they compute."""

from __future__ import annotations

import os
import pickle
import select
import signal
import sys
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from typing import NoReturn, TypeVar

from drake_ltl.errors import SearchLimitError

T = TypeVar("T")

_PR_SET_PDEATHSIG = 1
_PR_SET_CHILD_SUBREAPER = 36
"""Of Linux's prctl: the signal a process gets when its parent ends; that a process is the parent of all below it."""


def fork() -> int:
    """`os.fork`, except that the child ends with its parent, however that ends (on Linux)."""
    parent = os.getpid()
    with warnings.catch_warnings():
        # Python warns of locks that other threads hold; the children here neither log nor wait for threads.
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        end_with(parent)
    return child


def end_with(parent: int) -> None:
    """From now on this process ends as soon as its parent does (on Linux)."""
    if sys.platform == "linux":
        _prctl(_PR_SET_PDEATHSIG, int(signal.SIGKILL))
        if os.getppid() != parent:
            os._exit(1)


def adopt() -> None:
    """Makes this process the parent of what its children leave behind (on Linux)."""
    if sys.platform == "linux":
        _prctl(_PR_SET_CHILD_SUBREAPER, 1)


def bury(seconds: float) -> None:
    """Waits until all children have ended, but not longer than some time."""
    end = time.monotonic() + seconds
    with suppress(ChildProcessError):
        while time.monotonic() < end:
            if os.waitpid(-1, os.WNOHANG)[0] == 0:
                time.sleep(0.005)


def _prctl(option: int, value: int) -> None:
    import ctypes  # takes a while to load

    ctypes.CDLL(None).prctl(option, value)


def apart(function: Callable[..., T], *arguments: object, seconds: float | None = None) -> T:
    """What a function returns or raises, found by a child process while this one listens to signals.

    An exception from a signal's handler, such as KeyboardInterrupt, ends the child as well.

    Args:
        function: returns or raises something that can be pickled, and has no side effects.
        seconds: time for it; None: any.

    Raises:
        TimeoutError: time is over.
        SearchLimitError: the child was ended from outside, as happens when memory is short.
    """
    reading, writing = os.pipe()
    child = 0
    # A signal between the fork and the guard below would leave the child alone.
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM, signal.SIGALRM})
    try:
        child = fork()
        if child == 0:
            _answer(function, arguments, writing, mask)
        os.close(writing)
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        data = _read(reading, seconds)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        os.close(reading)
        if child:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
    if not data:
        raise SearchLimitError("the work in a process of its own was ended from outside; perhaps memory was short")
    good, result = pickle.loads(data)
    if not good:
        raise result
    return result


def _answer(function: Callable[..., object], arguments: tuple, writing: int, mask: set) -> NoReturn:
    """The child: leaves without any of what a process does at its end, for all that belongs to the parent."""
    with suppress(BaseException):
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides
        for other in (signal.SIGTERM, signal.SIGALRM):
            signal.signal(other, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        try:
            result = True, function(*arguments)
        except Exception as error:
            result = False, error
        with os.fdopen(writing, "wb") as file:
            pickle.dump(result, file)
    os._exit(0)


def _read(reading: int, seconds: float | None) -> bytes:
    """All that is written into a pipe until its other end is closed."""
    end = None if seconds is None else time.monotonic() + seconds
    parts = []
    while True:
        left = None if end is None else max(0.0, end - time.monotonic())
        if not select.select([reading], [], [], left)[0]:
            raise TimeoutError(f"no answer within {seconds:g} s")
        parts.append(os.read(reading, 1 << 16))
        if not parts[-1]:
            return b"".join(parts)
