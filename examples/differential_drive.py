"""Three robots on two driven wheels each cross each other's way to goal poses, around a pillar.

    python examples/differential_drive.py --meshcat

They cannot move sideways: nothing but the friction of their tyres ties them to the floor. The law is that of
docs/navigation.md, "Bases that cannot move sideways". Prints what it measured; the exit status is 0 if all robots
arrived, no spheres met, V did not rise, no tyre slipped and no torque exceeded its limit.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import numpy as np
from drake_ltl.diagrams.drive_diagram import Drive, MakeDriveDiagram

from drake_ltl.errors import DrakeLtlError
from drake_ltl.execution.drive_run import RunDrives
from drake_ltl.navigation import StaticBody

DRIVES = (
    Drive("a1", start=(-2.4, 0.3, np.pi / 2), goal=(2.4, 0.0, 0.0)),
    Drive("a2", start=(2.3, -0.5, np.pi), goal=(-2.3, -1.0, np.pi / 2)),
    Drive("a3", start=(0.6, 2.4, 0.0), goal=(0.8, -2.3, np.pi)),
)
"""Headings in rad: a1 sets out across its way, a2 and a3 arrive across theirs."""
PILLAR = StaticBody("pillar", 0.3, (0.1, 0.1, 0.1))


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--time-limit", type=float, default=60.0, help="of simulated time [s] (default: 60)")
    parser.add_argument("--meshcat", action="store_true", help="show it in a browser, and wait for Enter at the end")
    args = parser.parse_args(arguments)
    meshcat = None
    if args.meshcat:
        from pydrake.geometry import Meshcat, MeshcatParams

        meshcat = Meshcat(MeshcatParams(host="localhost", port=0))
        print(f"watch at {meshcat.web_url()}")
    try:
        run = RunDrives(MakeDriveDiagram(DRIVES, obstacles=[PILLAR], meshcat=meshcat), time_limit=args.time_limit)
    except DrakeLtlError as error:
        print(error, file=sys.stderr)
        return 2
    print(run)
    violations = run.violations()
    print("\n".join(f"VIOLATED: {violation}" for violation in violations) or "SATISFIED")
    if meshcat is not None:
        input("press Enter to end ")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main())
