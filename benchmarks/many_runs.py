"""A thousand runs of the two cases and of random missions, each judged three times. Part of `make soak`.

    python benchmarks/many_runs.py --runs 1000 --seed 1 --jobs 2     # goes on where it was interrupted
    python benchmarks/many_runs.py --seed 1 --only 17                # one run, with its scenario and its recording

Starts, gains and masses are drawn as `drake-ltl sweep` does it; missions in between by `random_missions`. While a run
goes on monitors watch it; when it is over `drake_ltl.verification.verify` judges it, and `second_look`, which shares no
code with it, judges the recording's file. A run that `verify` calls satisfied and `second_look` does not is a false
"satisfied"; that monitors and verdict say the same is seen as well.
"""

from __future__ import annotations

import argparse
import dataclasses
import functools
import json
import os
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any

import random_missions
import second_look
from random_missions import CrowdedError

from drake_ltl import mission
from drake_ltl.errors import InfeasibleError, InvalidInputError, SearchLimitError
from drake_ltl.multibody import MeasuredModels
from drake_ltl.scenario import Scenario, load, loads
from drake_ltl.sweep.collect import collect
from drake_ltl.sweep.drawing import draw, drawn_scenario
from drake_ltl.sweep.journal import versions
from drake_ltl.sweep.one_run import carry_out
from drake_ltl.sweep.outcome import SATISFIED, Outcome, outcome_to_json
from drake_ltl.sweep.processes import SteadyProcesses
from drake_ltl.sweep.sweep import Sweep
from drake_ltl.systems.preflight import check_fields
from drake_ltl.systems.program import mission_program

ROOT = Path(__file__).resolve().parents[1]
NAME = "many_runs.jsonl"
CASES = {"case_ii": (50, 7), "case_i": (100, 33)}
"""Example -> every so many runs is one of it, and which; all others are random missions."""
MOST_STEPS = 6
"""Of a random mission's plan with one round: there are to be a thousand runs."""
_MEASURED: dict[str, MeasuredModels] = {}
A2, A1 = ("is", "a2", "pi3"), ("is", "a1", "pi3")
O1, O1_END, O2 = ("is", "o1", "pi1"), ("is", "o1", "pi4"), ("is", "o2", "pi3")
FORMULAS = {
    "case_i": (
        ("G", ("!", A1)),
        ("G", ("F", A2)),
        ("G", ("F", O1)),
        ("G", ("|", ("!", O1), ("X", O1_END))),
        ("F", ("is", "o2", "pi4")),
    ),
    "case_ii": (
        ("G", ("!", A1)),
        ("G", ("F", A2)),
        ("G", ("F", O1)),
        ("G", ("|", ("!", O1), ("F", O1_END))),
        ("G", ("F", O2)),
    ),
}
"""Of the examples, as trees."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--only", type=int)
    parser.add_argument("--output", type=Path, default=ROOT / "out" / "soak")
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    if args.only is not None:
        print(json.dumps(run_one(args.seed, args.only, keep=args.output), indent=2))
        return
    rows = resumed(args.output / NAME, args.seed)
    missing = [number for number in range(args.runs) if number not in rows]
    with (args.output / NAME).open("a", encoding="utf-8") as file, SteadyProcesses(args.jobs) as executor:

        def keep(row: dict[str, Any] | Outcome) -> None:
            row = row if isinstance(row, dict) else row_of(row, "unknown", [], [])  # of a worker that ended
            rows[row["run"]] = row
            file.write(json.dumps(row) + "\n")
            file.flush()
            if is_remarkable(row):
                print(json.dumps({key: row[key] for key in ("run", "mission", "status", "reason", "second_look")}))

        collect(missing, functools.partial(run_one, args.seed), executor, keep, width=args.jobs)
    sys.exit(1 if any(map(is_remarkable, rows.values())) else 0)


def resumed(path: Path, seed: int) -> dict[int, dict[str, Any]]:
    """run -> its row. Begins the journal if there is none; a row that was cut off is dropped, its run done again."""
    header = {"seed": seed, "versions": versions()}
    lines = path.read_text(encoding="utf-8").split("\n")[:-1] if path.is_file() else []
    if lines and json.loads(lines[0]) != header:
        sys.exit(f"{path} is of another seed or of other versions; name another folder with `--output`")
    path.write_text("".join(f"{line}\n" for line in lines or [json.dumps(header)]), encoding="utf-8")
    return {row["run"]: row for row in map(json.loads, lines[1:])}


def is_remarkable(row: dict[str, Any]) -> bool:
    return row["status"] != SATISFIED or bool(row["monitored"] or row["second_look"])


def run_one(seed: int, number: int, keep: Path | None = None) -> dict[str, Any]:
    """Row `number` of the journal; `keep`: a folder for the scenario and the recording."""
    name, (sweep, formulas, refused) = sweep_of(seed, number)
    result = carry_out(sweep, number, models=models_of(sweep.scenario))
    if result.run is None:
        return row_of(result.outcome, name, [], []) | {"refused": refused}
    with tempfile.TemporaryDirectory() as folder:
        path = (keep or Path(folder)) / f"many_{number}.npz"
        result.run.recording.save(path)
        if keep is not None:
            path.with_suffix(".yaml").write_text(result.scenario.source, encoding="utf-8")
        monitored = [str(seen) for seen in result.run.recording.monitored]
        looked = second_look.findings(path, formulas)
    return row_of(result.outcome, name, monitored, looked) | {"refused": refused}


def row_of(outcome: Outcome, name: str, monitored: list[str], looked: list[str]) -> dict[str, Any]:
    return outcome_to_json(outcome) | {"mission": name, "monitored": monitored, "second_look": looked}


def sweep_of(seed: int, number: int) -> tuple[str, tuple[Sweep, tuple, list[str]]]:
    """What is carried out: the mission's name; its sweep, its formulas, and what was drawn in vain before."""
    for name, (every, first) in CASES.items():
        if number % every == first:
            return name, (planned(load(ROOT / "examples" / f"{name}.yaml"), seed), FORMULAS[name], [])
    return "random", random_sweep(seed, number)


def models_of(scenario: Scenario) -> MeasuredModels:
    """Measured once for all missions of the same robots and objects, wherever these stand and whatever they must do."""
    agents = [dataclasses.replace(agent, position=(0.0, 0.0), power=0.0, spec="1") for agent in scenario.agents]
    objects = [dataclasses.replace(obj, position=(0.0, 0.0), power_needed=0.0, spec="1") for obj in scenario.objects]
    key = repr((agents, objects))
    if key not in _MEASURED:
        _MEASURED[key] = mission.measure(scenario)
    return _MEASURED[key]


def planned(scenario: Scenario, seed: int) -> Sweep:
    models = models_of(scenario)
    plan = mission.plan_and_place(scenario, models).plan
    return Sweep(scenario=scenario, geometry=models.geometry, plan=plan, seed=seed)


def check_start(sweep: Sweep, number: int) -> None:
    """Raises InvalidInputError where `simulate` would refuse what is drawn for a run."""
    scenario = drawn_scenario(sweep.scenario, draw(sweep, number))
    models = models_of(scenario)
    with suppress(InfeasibleError, SearchLimitError):  # an outcome of the run
        check_fields(mission_program(mission.plan_and_place(scenario, models), models, scenario), scenario, models)


def random_sweep(seed: int, number: int) -> tuple[Sweep, tuple, list[str]]:
    """The first drawn mission that has a plan in which something happens, and that is not too long."""
    refused: list[str] = []
    while True:
        try:
            drawn = random_missions.draw(f"{seed} {number} {len(refused)}")
            sweep = planned(loads(drawn.text, source_name="random"), seed)
            check_start(sweep, number)
        except (CrowdedError, InvalidInputError, InfeasibleError, SearchLimitError) as error:
            refused.append(type(error).__name__)
            continue
        steps = len(sweep.plan.prefix) + len(sweep.plan.suffix)
        if sweep.plan.cost > 0.0 and steps <= MOST_STEPS:
            return sweep, drawn.formulas, refused
        refused.append("nothing to do" if steps <= MOST_STEPS else "long")


if __name__ == "__main__":
    main()
