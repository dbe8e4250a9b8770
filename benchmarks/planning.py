"""How long planning takes: `make bench`, or `python benchmarks/planning.py --help`.

Each measurement is the first one of a fresh process, with all libraries loaded; medians of several are shown. The two
cases of the paper are held against Spot, which finds *some* lasso in the product of TS with the automaton: translation
and emptiness check on the fly, TS being there already as Spot's own Kripke structure (to form that from Python is
measured by itself).
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import statistics
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table
from ring import ring

from drake_ltl.errors import DrakeLtlError
from drake_ltl.planning.automaton import letters
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.methods import Method, plan_by
from drake_ltl.planning.plan import State
from drake_ltl.planning.planner import plan
from drake_ltl.planning.power import sum_rule
from drake_ltl.planning.transition_system import TransitionSystem, form
from drake_ltl.scenario import load
from drake_ltl.scenario.formulas import global_formula
from drake_ltl.scenario.model import Agent, Scenario
from drake_ltl.spot_support import require_spot

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
CASES = {  # where everybody is at the start
    "case_i": State(("pi1", "pi3"), ("pi2", "pi1"), (None,) * 2),
    "case_ii": State(("pi1", "pi3", "pi4"), ("pi2", "pi1"), (None,) * 3),
}
FURTHER_STARTS = ("pi2", "pi1", "pi3", "pi4")
"""Of the agents that join case ii, each with power 3."""

LIMITS = {  # work -> (most milliseconds, most times Spot's)
    "case_i": (15.0, 3.0),
    "case_ii": (90.0, 2.5),
}
TEAMS = {4: (6935.0, 1.0, 512.0), 5: (7299.0, 5.0, 512.0), 7: (9036.0, 120.0, 1536.0)}
"""N -> (cost, most seconds, most megabytes)."""

RINGS = {"10 4 6": "gap <= 5 % in 60 s", "16 5 8": "a plan in 60 s", "30 10 10": "a plan in 60 s"}
"""Agents, objects and regions of `ring` -> what is wanted."""
RING_SECONDS = 60.0


def main() -> None:
    parser = argparse.ArgumentParser(description="Measures planning; prints a table and writes JSON.")
    parser.add_argument("--runs", type=int, default=7, help="fresh processes for each short measurement")
    parser.add_argument("--json", type=Path, default=Path("out/benchmark_planning.json"))
    parser.add_argument("--work", nargs="*", default=list(WORK), choices=WORK, help="what to measure")
    parser.add_argument("--time-limit", type=float, default=300.0, help="for one team [s]")
    parser.add_argument("--measure", nargs=2, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.measure:
        what, which = args.measure
        print(json.dumps(MEASURES[what](which)))
        return
    results: dict[str, Any] = {"machine": {"cores": os.cpu_count(), "python": platform.python_version()}}
    results["load"] = os.getloadavg()
    for name in args.work:
        results[name] = WORK[name](args)
    args.json.parent.mkdir(parents=True, exist_ok=True)
    args.json.write_text(json.dumps(results, indent=2) + "\n")
    show(results)


# In fresh processes


def in_fresh_process(what: str, which: str, time_limit: float = 600.0) -> dict[str, Any]:
    """One measurement; {"failed": why} if the process does not come to an end."""
    command = [sys.executable, __file__, "--measure", what, which]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=time_limit, check=True)
    except subprocess.TimeoutExpired:
        return {"failed": f"not finished after {time_limit:g} s"}
    except subprocess.CalledProcessError as error:
        return {"failed": (error.stderr or f"status {error.returncode}").strip().splitlines()[-1]}
    return json.loads(done.stdout)


def medians(runs: list[dict[str, Any]]) -> dict[str, Any]:
    """The medians of numbers, the least of them, and whatever is no number once."""
    numbers = [key for key, value in runs[0].items() if isinstance(value, float)]
    result = {key: value for key, value in runs[0].items() if key not in numbers}
    result |= {key: statistics.median(run[key] for run in runs) for key in numbers}
    return result | {f"least_{key}": min(run[key] for run in runs) for key in numbers if key.endswith("_ms")}


def measure_cases(args: argparse.Namespace) -> dict[str, Any]:
    """Planning and Spot's emptiness check in turn, so that both meet the same load."""
    results = {}
    for case in CASES:
        ours, spots = [], []
        for _ in range(args.runs):
            ours.append(in_fresh_process("plan", case))
            spots.append(in_fresh_process("spot", case))
        failures = [run for run in ours + spots if "failed" in run]
        results[case] = failures[0] if failures else medians(ours) | medians(spots)
    return results


def measure_process(args: argparse.Namespace) -> dict[str, Any]:
    """`drake-ltl plan examples/case_i.yaml` as a whole."""
    command = [str(Path(sys.executable).with_name("drake-ltl")), "plan", str(EXAMPLES / "case_i.yaml")]
    runs = []
    for _ in range(args.runs):
        began, used = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, capture_output=True, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu = after.ru_utime + after.ru_stime - used.ru_utime - used.ru_stime
        runs.append({"wall_ms": 1e3 * (time.perf_counter() - began), "cpu_ms": 1e3 * cpu})
    return medians(runs)


def measure_teams(args: argparse.Namespace) -> dict[str, Any]:
    """Case ii's formulas with more agents."""
    return {str(n): in_fresh_process("team", str(n), args.time_limit) for n in TEAMS}


def measure_rings(args: argparse.Namespace) -> dict[str, Any]:
    """The seeded problems, by the bounded method."""
    return {size: in_fresh_process("ring", size, args.time_limit) for size in RINGS}


WORK = {"cases": measure_cases, "process": measure_process, "teams": measure_teams, "rings": measure_rings}


# What is measured


def _megabytes() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def measure_plan(case: str) -> dict[str, Any]:
    scenario = load(EXAMPLES / f"{case}.yaml")
    began, used = time.perf_counter(), time.process_time()
    found = plan(scenario, CASES[case], published_fits(scenario.fits))
    wall, cpu = time.perf_counter() - began, time.process_time() - used
    parts = {f"{name}_ms": 1e3 * seconds for name, seconds in found.seconds.items() if name != "total"}
    return {
        "status": found.status,
        "cost": found.cost,
        "moves": len(found.moves),
        "counts": dict(found.counts),
        "plan_ms": 1e3 * wall,
        "plan_cpu_ms": 1e3 * cpu,
        **parts,
        "megabytes": _megabytes(),
    }


def measure_spot(case: str) -> dict[str, Any]:
    """Spot's any lasso of the same TS."""
    scenario = load(EXAMPLES / f"{case}.yaml")
    spot = require_spot()
    formula = spot.formula(global_formula(scenario))
    system = form(scenario, published_fits(scenario.fits), sum_rule(scenario))
    began = time.perf_counter()
    structure = kripke(spot, system, formula, system.index(CASES[case]))
    formed, used = time.perf_counter(), time.process_time()
    automaton = formula.translate("tgba", dict=structure.get_dict())
    empty = spot.otf_product(structure, automaton).is_empty()
    wall, cpu = time.perf_counter() - formed, time.process_time() - used
    assert not empty
    return {"kripke_ms": 1e3 * (formed - began), "spot_ms": 1e3 * wall, "spot_cpu_ms": 1e3 * cpu}


def kripke(spot: Any, system: TransitionSystem, formula: Any, start: int) -> Any:
    """TS as Spot's Kripke structure, with the propositions of the formula."""
    import buddy

    graph = spot.make_kripke_graph(spot.make_bdd_dict())
    propositions = sorted(ap.ap_name() for ap in spot.atomic_prop_collect(formula))
    variables = [graph.register_ap(name) for name in propositions]
    different, letter = letters(system, propositions)
    conditions = []
    for row in different.tolist():
        condition = buddy.bddtrue
        for variable, holds in zip(variables, row, strict=True):
            condition &= buddy.bdd_ithvar(variable) if holds else buddy.bdd_nithvar(variable)
        conditions.append(condition)
    for index in letter.tolist():
        graph.new_state(conditions[index])
    for source, target in zip(system.sources.tolist(), system.targets.tolist(), strict=True):
        graph.new_edge(source, target)
    graph.set_init_state(start)
    return graph


def measure_team(n_agents: str) -> dict[str, Any]:
    return measure_method("auto", *team(int(n_agents)), TEAMS[int(n_agents)][1])


def measure_ring(size: str) -> dict[str, Any]:
    return measure_method("bounded", *ring(*map(int, size.split())), RING_SECONDS)


def measure_method(method: Method, scenario: Scenario, start: State, time_limit: float) -> dict[str, Any]:
    """A plan by `plan_by`, its bound, time and memory."""
    began, used = time.perf_counter(), time.process_time()
    try:
        found, method = plan_by(method, scenario, start, published_fits(scenario.fits), time_limit=time_limit)
    except DrakeLtlError as error:
        return {"failed": str(error), "seconds": time.perf_counter() - began, "megabytes": _megabytes()}
    return {
        "status": found.status,
        "method": method,
        "cost": found.cost,
        "lower_bound": found.lower_bound,
        "seconds": time.perf_counter() - began,
        "cpu_seconds": time.process_time() - used,
        "megabytes": _megabytes(),
    }


def team(n_agents: int) -> tuple[Scenario, State]:
    """Case ii with further agents, of power 3 and without formulas."""
    scenario, start = load(EXAMPLES / "case_ii.yaml"), CASES["case_ii"]
    starts = FURTHER_STARTS[: n_agents - 3]
    if n_agents > 3 + len(FURTHER_STARTS) or n_agents < 3:
        raise ValueError(f"{n_agents} agents: 3 to {3 + len(FURTHER_STARTS)} are known")
    more = tuple(
        Agent(f"a{i}", scenario.agents[2].model, (0.0, 0.0), 0.0, 3.0, radius=1.25) for i in range(4, n_agents + 1)
    )
    return (
        replace(scenario, agents=scenario.agents + more),
        State(start.agents + starts, start.objects, (None,) * n_agents),
    )


MEASURES = {"plan": measure_plan, "spot": measure_spot, "team": measure_team, "ring": measure_ring}


# What is shown


def show(results: dict[str, Any]) -> None:
    """The table, on the terminal."""
    table = Table(title=f"Planning (load average {results['load'][0]:.1f} on {results['machine']['cores']} cores)")
    for heading in ("work", "found", "measured", "wanted"):
        table.add_column(heading)
    for case, run in results.get("cases", {}).items():
        if "failed" in run:
            table.add_row(case, "", run["failed"], "")
            continue
        most, times = LIMITS[case]
        ratio = run["plan_ms"] / run["spot_ms"]
        table.add_row(
            case,
            f"{run['status']}, {run['cost']:g} in {run['moves']} moves",
            f"{run['plan_ms']:.1f} ms (least {run['least_plan_ms']:.1f}, CPU {run['plan_cpu_ms']:.1f}), "
            f"{ratio:.1f} x Spot's {run['spot_ms']:.1f} ms (Kripke structure {run['kripke_ms']:.1f} ms)",
            f"{most:g} ms, {times:g} x",
        )
    if run := results.get("process"):
        text = f"{run['wall_ms']:.0f} ms (least {run['least_wall_ms']:.0f}, CPU {run['cpu_ms']:.0f})"
        table.add_row("drake-ltl plan case_i.yaml", "", text, "700 ms")
    for n_agents, run in results.get("teams", {}).items():
        cost, seconds, megabytes = TEAMS[int(n_agents)]
        table.add_row(f"case ii, N={n_agents}", *_said(run), f"{cost:g} in {seconds:g} s, {megabytes:g} MB")
    for size, run in results.get("rings", {}).items():
        table.add_row("ring, N={} M={} K={}".format(*size.split()), *_said(run), RINGS[size])
    Console().print(table)


def _said(run: dict[str, Any]) -> tuple[str, str]:
    used = f"{run['seconds']:.1f} s, {run['megabytes']:.0f} MB" if "seconds" in run else ""
    if "failed" in run:
        return run["failed"], used
    gap = f", gap {1.0 - run['lower_bound'] / run['cost']:.1%}" if run["status"] == "feasible" else ""
    return f"{run['status']} ({run['method']}), {run['cost']:g}{gap}", used


if __name__ == "__main__":
    main()
