"""A small valid scenario to spoil, and what the reader says of it then."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
import yaml

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.scenario import loads

ARM = "package://drake_ltl_models/agents/planar_arm.urdf"
CRATE = "package://drake_ltl_models/objects/crate.sdf"


@pytest.fixture
def data() -> dict[str, Any]:
    """Two regions, two agents and a crate, as YAML would give them."""
    return {
        "name": "small",
        "workspace": {"radius": 20},
        "regions": {
            "pi1": {"centre": [0, 0, 0], "radius": 3.5},
            "pi2": {"centre": [10, 0, 0], "radius": 3.5},
        },
        "agents": {
            "a1": {"model": ARM, "position": [0, 0], "spec": "GF pi2"},
            "a2": {"model": ARM, "position": [10, 1]},
        },
        "objects": {"o1": {"model": CRATE, "position": [10, -1], "power_needed": 2, "spec": "F pi1"}},
    }


@pytest.fixture
def complaints() -> Callable[[Any], list[Mistake]]:
    """All mistakes that the reader finds in a text, or in a structure written as one."""

    def read(scenario: Any) -> list[Mistake]:
        text = scenario if isinstance(scenario, str) else yaml.safe_dump(scenario, sort_keys=False)
        with pytest.raises(InvalidInputError) as caught:
            loads(text, source_name="small.yaml")
        assert all(len(str(mistake).splitlines()) == 1 for mistake in caught.value.mistakes)
        return list(caught.value.mistakes)

    return read
