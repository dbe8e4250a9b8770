"""The programs of the folder `benchmarks`, which are no package."""

from __future__ import annotations

import importlib
import sys

import pytest


@pytest.fixture
def program(request, monkeypatch):
    """program("second_look"): the module of that name."""
    monkeypatch.syspath_prepend(request.config.rootpath / "benchmarks")

    def load(name: str):
        monkeypatch.delitem(sys.modules, name, raising=False)
        return importlib.import_module(name)

    return load
