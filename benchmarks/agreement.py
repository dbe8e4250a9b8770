"""Bounded plans against proven optima: small rings, planned by both methods; exits 1 at any disagreement.

    python benchmarks/agreement.py --problems 200 --seconds 2

A disagreement is a bound above the optimum, a plan below it, or a plan said to be optimal that costs more.
"""

from __future__ import annotations

import argparse
import json
import random
import sys
from collections import Counter

from ring import ring

from drake_ltl.errors import InfeasibleError, SearchLimitError
from drake_ltl.planning.bounded import plan_bounded
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.planner import plan

_SAME = 1e-9
"""Relative difference of sums of the same costs."""


def compare(seed: int, seconds: float) -> dict[str, object]:
    """One problem: what both methods say, and whether that can be true of the same problem."""
    chance = random.Random(seed)
    size = chance.randint(2, 3), chance.randint(1, 2), chance.randint(3, 5)
    scenario, start = ring(*size, seed)
    fits = published_fits(scenario.fits)
    try:
        least = plan(scenario, start, fits).cost
    except InfeasibleError:
        least = None
    try:
        found = plan_bounded(scenario, start, fits, time_limit=seconds)
    except (InfeasibleError, SearchLimitError) as error:
        agrees = least is None or not isinstance(error, InfeasibleError)
        return {"seed": seed, "size": size, "optimum": least, "bounded": type(error).__name__, "agrees": agrees}
    agrees = least is not None and found.lower_bound <= least * (1.0 + _SAME) and found.cost >= least * (1.0 - _SAME)
    reached = agrees and found.cost <= least * (1.0 + _SAME)
    return {
        "seed": seed,
        "size": size,
        "optimum": least,
        "cost": found.cost,
        "lower_bound": found.lower_bound,
        "bounded": found.status,
        "reached": reached,
        "tight": agrees and found.lower_bound >= least * (1.0 - _SAME),
        "agrees": agrees and (reached or found.status != "optimal"),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--problems", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--seconds", type=float, default=2.0, help="for each bounded plan")
    args = parser.parse_args()
    counts: Counter[str] = Counter()
    for seed in range(args.first, args.first + args.problems):
        result = compare(seed, args.seconds)
        counts[str(result["bounded"])] += 1
        counts["optimum reached"] += bool(result.get("reached"))
        counts["bound tight"] += bool(result.get("tight"))
        counts["disagreements"] += not result["agrees"]
        if not result["agrees"] or result.get("reached") is False:
            print(json.dumps(result), flush=True)
    print(json.dumps({"problems": args.problems, **counts}))
    sys.exit(1 if counts["disagreements"] else 0)


if __name__ == "__main__":
    main()
