"""Everything drake_ltl raises on purpose, in one small tree."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path


class DrakeLtlError(Exception):
    """Base of all errors of drake_ltl."""


@dataclass(frozen=True)
class Mistake:
    """One thing that is wrong with an input: where it stands, what is wrong, what would be right."""

    where: str
    """Key path in the file, such as `agents.a1.radius`, or the file itself."""
    what: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.where}: {self.what}; {self.remedy}"


class InvalidInputError(DrakeLtlError):
    """An input that cannot be used. Carries every mistake found; prints one line for each."""

    def __init__(self, mistakes: Sequence[Mistake]):
        self.mistakes = tuple(mistakes)
        super().__init__("\n".join(str(mistake) for mistake in self.mistakes))


class MissingDependencyError(DrakeLtlError):
    """A library that is needed is not installed; the message says how to get it on this platform."""


class InfeasibleError(DrakeLtlError):
    """No plan satisfies the specification (or none can be carried out); the message says why."""


class NoPlacesError(InfeasibleError):
    """There are plans, but in none of those tried were places for the bodies found; the message says where not."""


class SearchLimitError(DrakeLtlError):
    """The problem is too large for the search: neither a plan nor a proof that there is none."""


class CertificateError(DrakeLtlError):
    """A plan failed its own check: a defect of the planner, never of the input."""


class PlacementError(DrakeLtlError):
    """A plan's bodies cannot be placed in their regions.

    `step` is the index of the plan's move that failed, `region` where it failed and `bodies` the agents and
    objects that are in each other's way there, as far as that is known.
    """

    def __init__(self, message: str, step: int, region: str | None = None, bodies: Sequence[str] = ()):
        self.step = step
        self.region = region
        self.bodies = tuple(bodies)
        super().__init__(message)


class GraspError(DrakeLtlError):
    """A weld was commanded while the end-effector was not where the grasp frame is."""


class ExecutionError(DrakeLtlError):
    """The simulated mission cannot go on (a state that is not finite, for instance)."""


@contextmanager
def naming_file(path: Path | str) -> Iterator[None]:
    """Lets an OSError of the body name the file: writing to a full disk, for instance, names none."""
    try:
        yield
    except OSError as error:
        if error.errno is not None:
            error.filename = str(path)
        raise
