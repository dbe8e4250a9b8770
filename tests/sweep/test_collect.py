"""Runs in processes that end, fail, or are interrupted."""

from __future__ import annotations

import functools
import time
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor

import pytest

from drake_ltl.errors import ExecutionError
from drake_ltl.sweep import processes
from drake_ltl.sweep.collect import ATTEMPTS, collect
from drake_ltl.sweep.processes import SteadyProcesses


def gather(executor: Executor, run, count: int = 6, width: int | None = 2) -> list:
    """What was kept, in order."""
    kept: list = []
    with executor:
        collect(range(count), run, executor, kept.append, width=width)
    return kept


def test_any_executor_will_do(fakes):
    for executor in (SteadyProcesses(2), ThreadPoolExecutor(3)):
        assert sorted(gather(executor, fakes.same)) == list(range(6))
    assert sorted(gather(ThreadPoolExecutor(3), fakes.same, width=None)) == list(range(6))


def test_a_killed_worker_loses_its_own_run_alone(fakes, tmp_path):
    kept = gather(SteadyProcesses(2), functools.partial(fakes.die_at_first, tmp_path, 1))
    assert sorted(kept) == list(range(6))
    assert sorted(fakes.calls(tmp_path)) == list(range(6))  # the others were carried out once


def test_a_run_that_kills_its_workers_fails_in_the_end(fakes, tmp_path):
    kept = gather(SteadyProcesses(2), functools.partial(fakes.die_always, tmp_path, 1), count=4)
    (failed,) = (one for one in kept if not isinstance(one, int))
    assert (failed.run, failed.status) == (1, "failed")
    assert f"ended in {ATTEMPTS} attempts" in failed.reason
    assert sorted(one for one in kept if isinstance(one, int)) == [0, 2, 3]
    calls = fakes.calls(tmp_path)
    assert [calls.count(number) for number in range(4)] == [1, ATTEMPTS, 1, 1]


def test_an_exception_is_an_outcome(fakes):
    kept = gather(ThreadPoolExecutor(2), functools.partial(fakes.fail, 2), count=3)
    (failed,) = (one for one in kept if not isinstance(one, int))
    assert (failed.run, failed.status, failed.reason) == (2, "failed", "ValueError: not a number")


def test_an_executor_that_stays_broken_ends_the_sweep(fakes, tmp_path):
    """An ordinary pool of processes takes nothing more once a process was killed."""
    with pytest.raises(ExecutionError, match="take no more runs"):
        gather(ProcessPoolExecutor(1), functools.partial(fakes.die_at_first, tmp_path, 0), width=1)


class Cancelled(Executor):
    """What a cluster does that goes away."""

    def submit(self, fn, /, *args, **kwargs) -> Future:
        future: Future = Future()
        future.cancel()
        future.set_running_or_notify_cancel()
        return future


def test_runs_that_a_cluster_gives_up_are_no_outcomes(fakes):
    with pytest.raises(ExecutionError, match="run 0 was given up"):
        gather(Cancelled(), fakes.same, width=1)


def test_processes_use_one_core_and_can_be_ended(fakes, monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "7")
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    with SteadyProcesses(1) as executor:
        found = [executor.submit(fakes.environment, f"{name}_NUM_THREADS").result() for name in ("OPENBLAS", "OMP")]
        assert executor.submit(fakes.sigterm_ends, 0).result()
    assert found == ["1", "1"]
    assert fakes.environment("OPENBLAS_NUM_THREADS") == "7"
    assert fakes.environment("OMP_NUM_THREADS") is None


def test_processes_make_room_for_others(fakes, tmp_path, monkeypatch):
    """What they keep is given back: each answers three calls here."""
    monkeypatch.setattr(processes, "MOST_CALLS", 3)
    kept = gather(SteadyProcesses(1), functools.partial(fakes.note, tmp_path), count=7, width=1)
    assert kept == list(range(7))
    identities = [line.split()[1] for line in (tmp_path / "calls").read_text(encoding="utf-8").splitlines()]
    assert [len(set(identities[k : k + 3])) for k in (0, 3, 6)] == [1, 1, 1]
    assert len(set(identities)) == 3


def test_an_interruption_ends_the_processes_at_once(fakes, tmp_path):
    """Else the test would last for 100 seconds, and the calls be seen to end."""
    futures = []

    def interrupted() -> None:
        with SteadyProcesses(2) as executor:
            futures.extend(executor.submit(fakes.slow, tmp_path, number) for number in range(3))
            while not (tmp_path / "calls").exists():
                time.sleep(0.02)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert all(future.cancelled() or isinstance(future.exception(), BrokenExecutor) for future in futures)
