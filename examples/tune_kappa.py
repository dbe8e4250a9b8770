"""Finds, for every step of a mission, a kappa without minima other than the goal.

    python examples/tune_kappa.py examples/case_ii.yaml --starts 20

Movers slide down each step's field from sampled starts; the printed report says from how many, and where the others got
stuck. The largest kappa found can stand in the scenario as `controller: {kappa: ...}`.
"""

from __future__ import annotations

import argparse
import sys

from drake_ltl import mission
from drake_ltl.errors import DrakeLtlError
from drake_ltl.scenario import load
from drake_ltl.systems.program import mission_program
from drake_ltl.systems.step_tuning import tune_steps


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", metavar="FILE", help="scenario (YAML)")
    parser.add_argument("--starts", type=int, default=20, help="sampled starts of each step (default: 20)")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    try:
        scenario = load(args.file)
        models = mission.measure(scenario)
        program = mission_program(mission.plan_and_place(scenario, models), models, scenario)
        tunings = tune_steps(program, scenario, models, n_starts=args.starts, seed=args.seed)
    except DrakeLtlError as error:
        print(error, file=sys.stderr)
        return 2
    for number, tuning in tunings.items():
        print(f"step {number + 1}\n{tuning}\n")
    return 0 if all(tuning.kappa is not None for tuning in tunings.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
