"""Whatever a scenario file holds: it loads, or all that is wrong is said. Nothing else is ever raised."""

from __future__ import annotations

import copy
import dataclasses
from pathlib import Path
from typing import Any

import yaml
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from drake_ltl.errors import InvalidInputError
from drake_ltl.scenario import loads
from drake_ltl.scenario.formulas import global_formula

TEXT = (Path(__file__).parents[2] / "examples" / "case_ii.yaml").read_text()
DATA = yaml.safe_load(TEXT)

leaves = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=12)
    | st.sampled_from([10**400, "pi1", "a1", "o1", "F pi1", "G (", "package://", "file://", "~nobody/x", "/", "."])
)
trees = st.recursive(
    leaves,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(leaves, inner, max_size=3),
    max_leaves=6,
)


def loads_or_complains(text: str) -> None:
    try:
        scenario = loads(text)
    except InvalidInputError as complaint:
        error = complaint
    else:
        assert scenario.agents
        assert scenario.regions
        assert None not in dataclasses.astuple(dataclasses.replace(scenario.controller, kappa=1.0))
        global_formula(scenario)
        return
    assert error.mistakes
    assert len(str(error).splitlines()) == len(error.mistakes)
    str(error).encode()  # what a terminal does with it


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The paths of all entries below `value`."""
    entries = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [found for key, entry in entries for found in ((*path, key), *places(entry, (*path, key)))]


@st.composite
def spoilt(draw: st.DrawFn) -> Any:
    """The example with some entries replaced, removed, renamed or added."""
    data = copy.deepcopy(DATA)
    for _ in range(draw(st.integers(1, 4))):
        candidates = places(data)
        if not candidates:
            break
        *path, key = draw(st.sampled_from(candidates))
        parent = data
        for step in path:
            parent = parent[step]
        action = draw(st.sampled_from(["replace", "remove", "rename", "add"]))
        if action == "replace":
            parent[key] = draw(trees)
        elif action == "remove":
            del parent[key]
        elif isinstance(parent, dict):
            parent[draw(leaves)] = parent.pop(key) if action == "rename" else draw(trees)
    return data


def written(data: Any) -> str:
    return yaml.dump(data, Dumper=_NoAliases, sort_keys=False, allow_unicode=True)


class _NoAliases(yaml.SafeDumper):
    def ignore_aliases(self, data: Any) -> bool:
        return True


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(spoilt())
def test_spoilt_structures(data):
    loads_or_complains(written(data))


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_spoilt_texts(data):
    start = data.draw(st.integers(0, len(TEXT)))
    length = data.draw(st.integers(0, 40))
    insert = data.draw(st.text(max_size=8) | st.sampled_from(["\t", "&a ", "*a", "!", "|", "? ", "- ", "<<: ", "\0"]))
    loads_or_complains(TEXT[:start] + insert + TEXT[start + length :])


@settings(max_examples=200, deadline=None)
@given(st.text(max_size=60) | trees.map(written))
@example("\ud800")
@example('name: "\\ud800"\n"\\ud800": 1')
@example("regions: {? 0xffffffffffffffff : 1}")
def test_any_text(text):
    loads_or_complains(text)


@settings(max_examples=300, deadline=None)
@given(
    st.lists(
        st.sampled_from(
            [
                "pi1",
                "a1.pi1",
                "G",
                "F",
                "X",
                "U",
                "M",
                "!",
                "&",
                "(",
                ")",
                "->",
                '"',
                "[",
                "{",
                ";",
                "=0",
                "\n",
            ]
        )
        | st.characters(),
        max_size=12,
    ).map(" ".join)
)
def test_any_formula(formula):
    data = copy.deepcopy(DATA)
    data["agents"]["a1"]["spec"] = data["spec"] = formula
    loads_or_complains(written(data))
