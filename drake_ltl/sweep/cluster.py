"""The executor of a cluster, by dask.distributed."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager

from drake_ltl.errors import InvalidInputError, MissingDependencyError, Mistake
from drake_ltl.sweep.journal import versions

PATIENCE = 10
"""For an answer of the scheduler [s]."""


@contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """The workers of the scheduler at an address such as `tcp://host:8786`. Runs not finished in the body are dropped.

    Raises:
        MissingDependencyError: dask.distributed is not installed.
        InvalidInputError: there is no scheduler, it has no workers, or their libraries are not those here.
    """
    try:
        from distributed import Client
    except ModuleNotFoundError as error:
        raise MissingDependencyError("clusters need dask.distributed: pip install 'drake-ltl[dask]'") from error
    if not address.strip():  # dask would start a cluster of its own
        raise _mistake(address, "is not an address", "write that of a scheduler, such as tcp://host:8786")
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # how connections end is of no interest
    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise _mistake(address, "no scheduler answers there", "start one with `dask scheduler`") from error
    with client:
        _check_workers(address, client.run(versions, on_error="return"))
        yield client.get_executor(pure=False)


def _check_workers(address: str, found: dict[str, object]) -> None:
    """A worker with other libraries could come to other outcomes, or to none."""
    if not found:
        raise _mistake(address, "the scheduler has no workers", f"start some with `dask worker {address} --nthreads 1`")
    others = [f"{worker} has {_shown(theirs)}" for worker, theirs in sorted(found.items()) if theirs != versions()]
    if others:
        raise _mistake(address, f"{others[0]}, not {_shown(versions())}", "install the same everywhere")


def _shown(theirs: object) -> str:
    if isinstance(theirs, dict):
        return ", ".join(f"{name} {version}" for name, version in theirs.items())
    return " ".join(str(theirs).split()) or type(theirs).__name__


def _mistake(address: str, what: str, remedy: str) -> InvalidInputError:
    return InvalidInputError([Mistake(f"--dask {address}", what, remedy)])
