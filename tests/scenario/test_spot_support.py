"""What is said where Spot is missing."""

from __future__ import annotations

import platform
import subprocess
import sys
import types

import pytest
import yaml

from drake_ltl.errors import MissingDependencyError
from drake_ltl.scenario import loads
from drake_ltl.spot_support import require_spot


@pytest.mark.parametrize(
    ("system", "machine", "command"),
    [
        ("Linux", "x86_64", "pip install spottl"),
        ("Linux", "aarch64", "conda install -c conda-forge spot"),
        ("Darwin", "arm64", "conda install -c conda-forge spot"),
    ],
)
def test_missing_spot_says_how_to_get_it(monkeypatch, data, system, machine, command):
    monkeypatch.setitem(sys.modules, "spot", None)
    monkeypatch.setattr(platform, "system", lambda: system)
    monkeypatch.setattr(platform, "machine", lambda: machine)
    with pytest.raises(MissingDependencyError, match=command):
        loads(yaml.safe_dump(data))


def test_another_module_of_that_name_is_not_taken_for_spot(monkeypatch):
    monkeypatch.setitem(sys.modules, "spot", types.ModuleType("spot"))
    with pytest.raises(MissingDependencyError, match="not the library of temporal logic"):
        require_spot()


def test_import_survives_warnings_as_errors():
    """The bindings of Spot themselves crash the interpreter there."""
    command = "from drake_ltl.spot_support import require_spot; print(require_spot().formula('F a'))"
    done = subprocess.run([sys.executable, "-W", "error", "-c", command], capture_output=True, text=True, check=True)
    assert done.stdout == "Fa\n"
