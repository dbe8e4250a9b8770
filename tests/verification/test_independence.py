"""A verdict shares no code with what it judges: nothing that verification imports, however far, drives or plans.

But for one thing: with lambda > 0, V has a term for every set of relations that may be realised at once. Which sets
these are is the definition of V, and is asked of `navigation.realisable_sets`.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import drake_ltl

SHARED = {("drake_ltl.verification.potential", "drake_ltl.navigation")}
"""(who imports, what)."""
PLAIN_DATA = {"drake_ltl.monitoring", "drake_ltl.monitoring.violation"}
"""What recordings hold."""
JUDGED = ("systems", "navigation", "dynamics", "diagrams", "monitoring", "mission", "api", "sweep", "cli")
JUDGED += ("execution.runner", "execution.log_reader", "execution.grasping", "execution.intervals", "visualization")


ROOT = Path(drake_ltl.__file__).parents[1]


@cache
def file_of(module: str) -> Path | None:
    """The source of a module of drake_ltl; None for what is none, such as a name that a module defines."""
    place = ROOT.joinpath(*module.split("."))
    if module.startswith(("drake_ltl.diagrams", "drake_ltl.models")):  # folders beside the package
        place = ROOT.joinpath(*module.split(".")[1:])
    files = (place.with_name(f"{place.name}.py"), place / "__init__.py")
    return next((file for file in files if file.is_file()), None)


def imports(module: str) -> Iterator[str]:
    """Modules of drake_ltl that a module loads when it is loaded; within verification also those that it loads later.

    Elsewhere functions load what only they need: how a scenario is shown in a notebook, for instance.
    """
    tree = ast.parse(file_of(module).read_text(encoding="utf-8"))
    if not module.startswith("drake_ltl.verification"):
        _drop_functions(tree)
    for node in _running(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0  # none is relative
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
        else:
            continue
        yield from (name for name in names if name.startswith("drake_ltl") and file_of(name) is not None)


def _drop_functions(tree: ast.AST) -> None:
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            node.body = []


def _running(tree: ast.AST) -> Iterator[ast.AST]:
    """All nodes but those for type checkers alone."""
    for_types = [node for node in ast.walk(tree) if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test)]
    skipped = {id(inner) for node in for_types for inner in ast.walk(node)}
    return (node for node in ast.walk(tree) if id(node) not in skipped)


def reached(start: list[str]) -> dict[str, str]:
    """module -> who imports it, for all that is reached from some modules, packages on the way included."""
    found, waiting = dict.fromkeys(start, ""), list(start)
    while waiting:
        module = waiting.pop()
        parts = module.split(".")
        parents = [".".join(parts[:k]) for k in range(2, len(parts))]  # `import drake_ltl` itself loads nothing
        for name in [*imports(module), *parents]:
            if name not in found and name != "drake_ltl" and (module, name) not in SHARED:
                found[name] = module
                waiting.append(name)
    return found


@pytest.fixture(scope="module")
def graph() -> dict[str, str]:
    folder = file_of("drake_ltl.verification").parent
    return reached([f"drake_ltl.verification.{path.stem}" for path in sorted(folder.glob("*.py"))])


def judged_in(graph: dict[str, str]) -> dict[str, str]:
    judged = {name: by for name, by in graph.items() if name.removeprefix("drake_ltl.").startswith(JUDGED)}
    return {name: by for name, by in judged.items() if name not in PLAIN_DATA}


def test_nothing_that_is_judged_is_imported(graph):
    assert judged_in(graph) == {}


def test_nothing_of_the_planner_is_used(graph):
    """Only the numbers measured of models are kept in its package."""
    users = {by for name, by in graph.items() if name.startswith("drake_ltl.planning")}
    users = {by for by in users if not by.startswith("drake_ltl.planning")}
    assert {by.rpartition(".")[0] for by in users} <= {"drake_ltl.multibody"}


def test_what_is_shared_is_one_function():
    tree = ast.parse(file_of("drake_ltl.verification.potential").read_text(encoding="utf-8"))
    found = [node for node in _running(tree) if isinstance(node, ast.ImportFrom) and "navigation" in node.module]
    names = {alias.name for node in found for alias in node.names}
    assert names == {"Apart", "Inside", "Relations", "realisable_sets"}


def test_the_walk_reaches_what_is_imported_within_functions(graph):
    """... and would reach the controllers: this test can fail."""
    assert {"drake_ltl.verification.models", "drake_ltl.multibody.agent_model", "drake_ltl.spot_support"} <= set(graph)
    assert {"drake_ltl.systems.mission_controller", "drake_ltl.navigation.step"} <= set(
        judged_in(reached(["drake_ltl.mission"]))
    )
