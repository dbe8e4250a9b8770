"""Lets an executor carry out runs, and hands every outcome on as soon as it is there."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait

from drake_ltl.errors import ExecutionError
from drake_ltl.sweep.outcome import FAILED, Outcome

ATTEMPTS = 3
"""A run whose worker ends so often is reported as failed."""


def collect(
    numbers: Iterable[int],
    run: Callable[[int], Outcome],
    executor: Executor,
    keep: Callable[[Outcome], None],
    *,
    width: int | None = None,
) -> None:
    """Carries out runs in any order.

    A run whose worker ended is done again. An executor that does so itself, as `dask.distributed`, has its own limit
    and then raises an exception of its own: the run counts as failed, as with any exception.

    Args:
        numbers: of the runs.
        run: can be pickled.
        keep: called in this thread with every outcome.
        width: so many runs are handed to the executor at a time; None: all at once.

    Raises:
        ExecutionError: the executor does not take or does not finish runs any more.
    """
    waiting, running = deque(numbers), dict[Future, int]()
    ends: Counter[int] = Counter()
    while waiting or running:
        while waiting and (width is None or len(running) < width):
            number = waiting.popleft()
            running[_submit(executor, run, number)] = number
        for future in wait(running, return_when=FIRST_COMPLETED).done:
            number = running.pop(future)
            try:
                keep(_outcome(future, number))
            except BrokenExecutor as error:
                ends[number] += 1
                if ends[number] < ATTEMPTS:
                    waiting.append(number)
                else:
                    keep(Outcome(number, FAILED, reason=f"its worker ended in {ATTEMPTS} attempts: {error}"))


def _submit(executor: Executor, run: Callable[[int], Outcome], number: int) -> Future:
    try:
        return executor.submit(run, number)
    except (BrokenExecutor, RuntimeError) as error:  # RuntimeError: after its shutdown
        raise ExecutionError(f"the workers take no more runs: {' '.join(str(error).split())}") from error


def _outcome(future: Future, number: int) -> Outcome:
    """Raises BrokenExecutor where the worker ended."""
    try:
        return future.result()
    except BrokenExecutor:
        raise
    except CancelledError as error:
        raise ExecutionError(f"run {number} was given up with all that waited for workers: they are gone") from error
    except Exception as error:
        return Outcome(number, FAILED, reason=" ".join(f"{type(error).__name__}: {error}".split()))
