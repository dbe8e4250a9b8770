"""What tests of sweeps share."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from drake_ltl.sweep.drawing import Drawn
from drake_ltl.sweep.outcome import Outcome


@pytest.fixture(scope="session")
def fakes() -> Iterator[ModuleType]:
    """Functions that other processes find, too: they get this process's path."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(Path(__file__).parent))
        yield importlib.import_module("fakes")
        patch.delitem(sys.modules, "fakes")


@pytest.fixture
def outcome():
    """outcome(3, "stalled", clearance=0.1, ...): an outcome with some numbers."""

    def make(run: int, status: str = "satisfied", *, clearance: float | None = 0.1, **others) -> Outcome:
        drawn = Drawn({"a1": (float(run), 0.5)}, {"force": 40.0 + run}, {"o1": 1.01})
        values = {
            "reason": "" if status == "satisfied" else f"step 1, 1.000 s: it is {status}",
            "drawn": drawn,
            "cost": 2.5,
            "durations": (1.0, 2.0 + run),
            "simulated_seconds": 3.0 + run,
            "min_clearance": {"agent_agent": clearance, "workspace": 1.0, "team_other": None},
            "max_lyapunov_increase": 0.0,
            "max_weld_error": 1e-4,
            "max_tilt": 0.01,
            "wall_seconds": 1.0 / (run + 1),
        }
        return Outcome(run, status, **{**values, **others})

    return make


@pytest.fixture(scope="session")
def sweep(case_ii, models, mission):
    """Of case ii, with the default disturbances."""
    from drake_ltl.sweep.sweep import Sweep

    return Sweep(case_ii, models.geometry, mission.plan, seed=3)
