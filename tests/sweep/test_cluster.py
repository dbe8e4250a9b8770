"""Runs on a cluster, which the test starts."""

from __future__ import annotations

import functools
import re
import sys

import pytest

import drake_ltl
from drake_ltl.errors import InvalidInputError, MissingDependencyError
from drake_ltl.sweep import cluster as module
from drake_ltl.sweep.cluster import cluster
from drake_ltl.sweep.collect import collect


def test_without_dask(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingDependencyError, match=r"pip install 'drake-ltl\[dask\]'"), cluster("tcp://localhost:1"):
        pass


@pytest.fixture(scope="module")
def local(fakes):
    """A scheduler and a worker on this machine; the worker must find what it is to call."""
    distributed = pytest.importorskip("distributed", reason="dask.distributed is not installed (extra `dask`)")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=True, dashboard_address="127.0.0.1:0", host="127.0.0.1"
    ) as started:
        yield started


def test_a_killed_worker_and_an_exception(local, fakes, tmp_path):
    kept = []
    with cluster(local.scheduler_address) as executor:
        collect(range(5), functools.partial(fakes.die_or_fail, tmp_path, 3, 1), executor, kept.append)
    assert sorted(one for one in kept if isinstance(one, int)) == [0, 2, 3, 4]
    assert (tmp_path / "died").exists()
    (failed,) = (one for one in kept if not isinstance(one, int))
    assert (failed.run, failed.reason) == (1, "ValueError: not a number")


def test_workers_with_other_libraries(local, monkeypatch):
    """A sweep with them would give numbers that cannot be had again."""
    monkeypatch.setattr(drake_ltl, "__version__", "9.9.9")
    with pytest.raises(InvalidInputError) as caught, cluster(local.scheduler_address):
        pass
    (line,) = str(caught.value).splitlines()
    assert "tcp://127.0.0.1:" in line
    assert re.search(r"has drake_ltl 0.*, not drake_ltl 9\.9\.9, .*; install the same everywhere$", line)


def test_a_cluster_without_workers():
    with pytest.raises(InvalidInputError, match="the scheduler has no workers; start some with `dask worker"):
        module._check_workers("tcp://x:1", {})


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense://x", "127.0.0.1:port", ""])
def test_where_no_scheduler_is(address, monkeypatch):
    pytest.importorskip("distributed", reason="dask.distributed is not installed (extra `dask`)")
    monkeypatch.setattr(module, "PATIENCE", 0.3)
    with pytest.raises(InvalidInputError) as caught, cluster(address):
        pass
    (line,) = str(caught.value).splitlines()
    assert ("no scheduler answers there; start one with" if address else "is not an address; write") in line
