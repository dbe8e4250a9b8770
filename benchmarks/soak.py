"""What takes hours: malformed inputs, interruptions, many rounds, many runs, plans of two methods. `make soak`.

    python benchmarks/soak.py                        # all of it, results into docs/soak.md
    python benchmarks/soak.py --parts malformed rounds
    python benchmarks/soak.py --parts                # only write the document, of what is in out/soak

Each part leaves its results in out/soak, and can be repeated by itself. Exit status 1 if one found something wrong.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from soak_document import SWEEPS, document

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--parts", nargs="*", default=list(PARTS), choices=list(PARTS))
    parser.add_argument("--output", type=Path, default=ROOT / "out" / "soak")
    parser.add_argument("--document", type=Path, default=ROOT / "docs" / "soak.md")
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    statuses = [PARTS[part](args.output) for part in args.parts]
    args.document.write_text("\n".join(document(args.output)) + "\n", encoding="utf-8")
    sys.exit(max(statuses, default=0))


# The parts: each runs a program, and returns its exit status


def malformed(output: Path) -> int:
    """Halves side by side."""
    arguments = ("--inputs", "5000", "--output", output)
    with ThreadPoolExecutor() as threads:
        return max(threads.map(lambda seed: _python("malformed.py", "--seed", seed, *arguments), (1, 2)))


def fuzz(output: Path) -> int:
    """Says so where there is no atheris."""
    return _python("fuzz.py", "--output", output)


def interruptions(output: Path) -> int:
    return _python("interruptions.py", "--output", output)


def many_runs(output: Path) -> int:
    """An interrupted one goes on where it was."""
    return _python("many_runs.py", "--runs", "1000", "--output", output)


def rounds(output: Path) -> int:
    return _python("long_run.py", "--rounds", "100", "--output", output)


def agreement(output: Path) -> int:
    with (output / "agreement.jsonl").open("w", encoding="utf-8") as file:
        return _python("agreement.py", "--problems", "1000", "--seconds", "1", stdout=file)


def sweeps(output: Path) -> int:
    """An interrupted one goes on where it was."""
    script, found = Path(sys.executable).with_name("drake-ltl"), []
    for name, runs in SWEEPS.items():
        folder = output / f"sweep_{name}"
        command = [script, "sweep", ROOT / "examples" / f"{name}.yaml", "--runs", str(runs), "--output", folder]
        found.append(subprocess.run([*command, "--seed", "1"], check=False).returncode)
    return max(found)


def _python(program: str, *arguments: object, stdout: Any = None) -> int:
    command = [sys.executable, str(HERE / program), *map(str, arguments)]
    return subprocess.run(command, stdout=stdout, check=False).returncode


PARTS = {
    "malformed": malformed,
    "fuzz": fuzz,
    "interruptions": interruptions,
    "rounds": rounds,
    "many_runs": many_runs,
    "agreement": agreement,
    "sweeps": sweeps,
}


if __name__ == "__main__":
    main()
