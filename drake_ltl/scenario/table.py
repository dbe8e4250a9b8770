"""Reading a map key by key, noting every mistake instead of stopping at the first."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

from drake_ltl.errors import Mistake

T = TypeVar("T")

LARGEST = 1e9
"""Largest magnitude of a number; squared distances of larger ones lose all digits."""
MOST_ENTRIES = 300
"""Regions, agents or objects; no planner comes near, and pairs of them are looked at."""
SMALLEST = 1e-9
"""Smallest positive number; the reciprocal of a smaller one is useless."""

_REQUIRED: Any = object()


class UnfitValueError(Exception):
    """A value that cannot be used: what is wrong with it, and what would be right."""

    def __init__(self, what: str, remedy: str):
        self.what = what
        self.remedy = remedy
        super().__init__(what, remedy)


class Table:
    """A map of the file, at the key path `path`; its mistakes go into the shared list `mistakes`."""

    def __init__(self, value: Any, path: str, mistakes: list[Mistake]):
        self.path = path
        self.mistakes = mistakes
        self._known: list[str] = []
        self.sound = value is None or isinstance(value, dict)
        if not self.sound:
            self.note(path, f"{shown(value)} is not a map", "write indented lines of `key: value` below it")
        self._entries: dict[Any, Any] = value if isinstance(value, dict) else {}

    def note(self, where: str, what: str, remedy: str) -> None:
        """Adds a mistake."""
        self.mistakes.append(Mistake(where, what, remedy))

    def where(self, key: Any) -> str:
        """The key path of an entry."""
        label = key if isinstance(key, str) and key.isprintable() and 0 < len(key) <= 80 else shown(key)
        return f"{self.path}.{label}" if self.path else label

    def __contains__(self, key: str) -> bool:
        return key in self._entries

    def take(self, key: str, read: Callable[[Any], T], default: Any = _REQUIRED) -> Any:
        """The entry `key` as `read` understands it; `default` if absent. After a mistake: None."""
        self._known.append(key)
        if key not in self._entries:
            if default is _REQUIRED and self.sound:
                self.note(self.where(key), "is missing", f"add a line `{key}: ...`")
            return None if default is _REQUIRED else default
        return self.attempt(key, lambda: read(self._entries[key]))

    def attempt(self, key: str, action: Callable[[], T]) -> T | None:
        """The result of `action`, or None after noting what it found unfit at the entry `key`."""
        try:
            return action()
        except UnfitValueError as error:
            self.note(self.where(key), error.what, error.remedy)
            return None

    def table(self, key: str) -> Table:
        """The map under `key`; empty if absent."""
        self._known.append(key)
        return Table(self._entries.get(key), self.where(key), self.mistakes)

    def tables(self) -> Iterator[tuple[Any, Table]]:
        """All entries as maps, by key: what a user named freely. Nothing, and a mistake, if there are too many."""
        if len(self._entries) > MOST_ENTRIES:
            self.note(self.path, f"there are {len(self._entries)}", f"write at most {MOST_ENTRIES}")
            self.sound = False
            return
        for key, value in self._entries.items():
            yield key, Table(value, self.where(key), self.mistakes)

    def peek(self, key: str) -> Any:
        """The entry `key` as it is; None if absent."""
        return self._entries.get(key)

    def __iter__(self) -> Iterator[Any]:
        """All keys, in the file's order."""
        return iter(self._entries)

    def close(self) -> None:
        """Notes every key that nobody asked for."""
        unknown = [key for key in self._entries if key not in self._known]
        if len(unknown) > MOST_ENTRIES:
            self.note(self.path or "the file", f"{len(unknown)} keys are unknown", f"use {listing(self._known)}")
        else:
            for key in unknown:
                remedy = f"{did_you_mean(key, self._known)}known keys: {listing(self._known)}"
                self.note(self.where(key), "is not a known key", remedy)


def shown(value: Any) -> str:
    """`repr(value)`, cut to a length that fits a line."""
    try:
        text = repr(value)
    except ValueError:  # integers of thousands of digits have no decimal text
        text = "a number of thousands of digits"
    return text if len(text) <= 80 else f"{text[:77]}..."


def printable(text: str) -> str:
    """The same text on one line, with escapes in place of what a terminal would obey."""
    return "".join(letter if letter.isprintable() else repr(letter)[1:-1] for letter in text)


def listing(names: Iterable[Any]) -> str:
    """Names as a readable list, cut to what one can take in."""
    words = [str(name)[:80] for name in names]
    more = [f"... ({len(words)} in all)"] if len(words) > 24 else []
    return ", ".join(words[:24] + more) or "none"


def did_you_mean(word: Any, known: Iterable[Any]) -> str:
    """`did you mean `x`? ` or nothing."""
    close = difflib.get_close_matches(str(word)[:80], [str(name)[:80] for name in known], 1)
    return f"did you mean `{close[0]}`? " if close else ""


def number(value: Any) -> float:
    """Any finite number of reasonable size."""
    return _number_between(value, -LARGEST, LARGEST, "a finite number")


def positive(value: Any) -> float:
    """A number greater than zero."""
    return _number_between(value, SMALLEST, LARGEST, "a positive number")


def not_negative(value: Any) -> float:
    """Zero or more."""
    return _number_between(value, 0.0, LARGEST, "zero or a positive number")


def at_most(largest: float) -> Callable[[Any], float]:
    """A reader of positive numbers that may not exceed `largest`."""
    return lambda value: _number_between(value, SMALLEST, largest, "a positive number")


def integer_from(smallest: int) -> Callable[[Any], int]:
    """A reader of whole numbers of at least `smallest`, that fit in 63 bits."""

    def read(value: Any) -> int:
        if isinstance(value, int) and not isinstance(value, bool) and smallest <= value < 2**63:
            return value
        raise UnfitValueError(
            f"{shown(value)} is not a whole number of at least {smallest}",
            f"write a whole number ({smallest} to 2^63 - 1)",
        )

    return read


def numbers(count: int, labels: str) -> Callable[[Any], tuple[float, ...]]:
    """A reader of lists of `count` numbers; `labels` says which, as `[x, y] in m`."""

    def read(value: Any) -> tuple[float, ...]:
        if not isinstance(value, list) or len(value) != count:
            raise UnfitValueError(f"{shown(value)} is not a list of {count} numbers", f"write {labels}")
        return tuple(number(entry) for entry in value)

    return read


def number_list(value: Any) -> tuple[float, ...]:
    """A list of numbers of any length."""
    if not isinstance(value, list):
        raise UnfitValueError(f"{shown(value)} is not a list of numbers", "write [q1, q2, ...] in rad (or m)")
    return tuple(number(entry) for entry in value)


def text(value: Any) -> str:
    """A line of at least one printable character, without spaces around it."""
    if not isinstance(value, str):
        raise UnfitValueError(f"{shown(value)} is not text", "write a text in quotes")
    if not value.strip() or not value.strip().isprintable():
        raise UnfitValueError(f"{shown(value)} is not printable text", "write one line of text")
    return value.strip()


def one_of(*choices: str) -> Callable[[Any], str]:
    """A reader of one of some words."""

    def read(value: Any) -> str:
        if isinstance(value, str) and value in choices:
            return value
        raise UnfitValueError(f"{shown(value)} is unknown", f"write one of {listing(choices)}")

    return read


def _number_between(value: Any, smallest: float, largest: float, kind: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        plainly = ", without quotes or a unit" if isinstance(value, str) else ""
        raise UnfitValueError(f"{shown(value)} is not a number", f"write {kind}{plainly}")
    remedy = f"write {kind} ({smallest:g} to {largest:g})"
    if not value >= smallest:  # refuses nan as well
        raise UnfitValueError(f"{shown(value)} is not {kind}", remedy)
    if value > largest:
        raise UnfitValueError(f"{shown(value)} is too large", remedy)
    return float(value)
