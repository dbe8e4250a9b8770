"""An executor of processes in which nothing is lost when one of them ends but the call that was in it.

A ProcessPoolExecutor of several processes gives all its calls up when one of its processes is killed, and nobody knows
then whose fault it was. Here every process is a pool of its own, made anew when it is broken.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from types import TracebackType
from typing import Any

from drake_ltl.processes import end_with

ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""What lets libraries of linear algebra use one core."""
MOST_CALLS = 50
"""A process that has answered so many makes room for another: Drake's Python keeps every diagram that has a system
written in Python for as long as the process lasts (1.51), which is megabytes for each run."""


class SteadyProcesses(Executor):
    """Processes that are started afresh (spawned), use a core each, and end when this one does.

    A call whose process ends raises BrokenProcessPool; those that were waiting for the same process as well, so submit
    no more calls at a time than there are processes. After `MOST_CALLS` calls a process makes room for another. As a
    context manager it waits for all calls, unless an exception (Ctrl-C, for instance) leaves it: then the processes are
    killed. To be used from one thread.
    """

    def __init__(self, processes: int):
        self._pools = [_pool() for _ in range(processes)]
        self._calls: list[list[Future]] = [[] for _ in self._pools]
        self._answered = [0] * processes

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future:
        """Calls the function in the process with the fewest calls."""
        index = min(range(len(self._pools)), key=self._load)
        if self._answered[index] >= MOST_CALLS and not self._calls[index]:
            self._pools[index].shutdown()
            self._renew(index)
        with _one_thread_each():
            try:
                future = self._pools[index].submit(fn, *args, **kwargs)
            except BrokenProcessPool:
                self._renew(index)
                future = self._pools[index].submit(fn, *args, **kwargs)
        self._calls[index].append(future)
        self._answered[index] += 1
        return future

    def _renew(self, index: int) -> None:
        self._pools[index], self._answered[index] = _pool(), 0

    def _load(self, index: int) -> int:
        self._calls[index] = [call for call in self._calls[index] if not call.done()]
        return len(self._calls[index])

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Lets the processes end, after the calls that are in them."""
        for pool in self._pools:
            pool.shutdown(wait=wait, cancel_futures=cancel_futures)

    def kill(self) -> None:
        """Ends the processes at once, with what is in them."""
        for pool in self._pools:
            for process in list((pool._processes or {}).values()):  # `kill_workers` from Python 3.14 on
                process.kill()
        self.shutdown(cancel_futures=True)

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if kind is None:
            self.shutdown()
        else:
            self.kill()


def _pool() -> ProcessPoolExecutor:
    """Processes are spawned: a fork would take threads' locks along."""
    spawn = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(1, mp_context=spawn, initializer=_begin, initargs=(os.getpid(),))


def _begin(parent: int) -> None:
    """In the new process, which inherits what its parent ignores."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    end_with(parent)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """For processes that are started in the body."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(ONE_THREAD)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
