"""Work in child processes that can be ended."""

from __future__ import annotations

import os
import signal
import time

import pytest

from drake_ltl.errors import InfeasibleError, SearchLimitError
from drake_ltl.processes import apart


def test_what_a_function_returns():
    assert apart(lambda *numbers: (os.getpid() != here, sum(numbers)), 1, 2, 3) == (True, 6)


here = os.getpid()


def test_more_than_a_pipe_holds():
    assert len(apart(bytes, 10_000_000)) == 10_000_000


def test_what_a_function_raises():
    def refuse() -> None:
        raise InfeasibleError("no")

    with pytest.raises(InfeasibleError, match=r"^no$"):
        apart(refuse)


def test_a_child_that_is_killed():
    with pytest.raises(SearchLimitError, match="ended from outside"):
        apart(lambda: os.kill(os.getpid(), signal.SIGKILL))


def sleep_in(file) -> None:
    file.write_text(str(os.getpid()), encoding="utf-8")
    time.sleep(100.0)


def is_gone(file) -> bool:
    try:
        os.kill(int(file.read_text(encoding="utf-8")), 0)
    except ProcessLookupError:
        return True
    return False


def test_time_is_over(tmp_path):
    with pytest.raises(TimeoutError, match=r"within 0\.5 s"):
        apart(sleep_in, tmp_path / "pid", seconds=0.5)
    assert is_gone(tmp_path / "pid")


def test_a_signal_s_handler_ends_it(tmp_path):
    def stop(*args: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, stop)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.5)
        with pytest.raises(KeyboardInterrupt):
            apart(sleep_in, tmp_path / "pid", seconds=60.0)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    assert is_gone(tmp_path / "pid")
    assert signal.pthread_sigmask(signal.SIG_BLOCK, ()) == set()
