"""Ways to spoil an input: each takes a random.Random and what is sound, and returns what may not be any more."""

from __future__ import annotations

import copy
import io
import json
from collections.abc import Callable
from functools import cache
from random import Random
from typing import Any

import numpy as np
import yaml

HUGE = 10**5000
NUMBERS = [0, -1, 1, 0.5, -0.0, 1e-320, 1e308, 1e400, float("nan"), float("-inf"), 2**63, 10**400, HUGE]
WORDS = [
    "",
    " ",
    "pi1",
    "a1",
    "o1",
    "a1.pi1",
    "Gripper",
    "\0",
    "\ud800",
    "é",
    "x" * 5000,
    "1e400",
    "~",
    "{}",
    "geometric",
]
FORMULAS = [
    "F",
    "F pi9",
    "G (",
    "pi1 U",
    "!" * 99,
    "(" * 9000,
    "X" * 900 + " pi1",
    "F[1:9] pi1",
    "{pi1[*]}|->pi2",
    "a1.pi1",
]
MODELS = [
    "/etc/passwd",
    "../x.urdf",
    "file:///etc/passwd",
    "http://host/x.urdf",
    "package://other/x",
    "~nobody/x",
    "/dev/zero",
]
SNIPPETS = ["\t", "&a ", "*a", "!!python/object/apply:os.system ", "!", "|", ">", "? ", "- ", "<<: ", "\0", "[", "{"]
SNIPPETS += [
    '"',
    "'",
    "#",
    ": ",
    "---\n",
    "...\n",
    "%YAML 9.9\n",
    "&a [*a, *a]",
    "[" * 3000,
    "{a: " * 3000,
    ".nan",
    "1e400",
]
SNIPPETS += ["0x" + "f" * 5000]


def value(chance: Random, depth: int = 2) -> Any:
    """Anything that YAML or JSON can hold."""
    kind = chance.randrange(8 if depth else 6)
    if kind == 6:
        return [value(chance, depth - 1) for _ in range(chance.randrange(4))]
    if kind == 7:
        return {chance.choice(WORDS): value(chance, depth - 1) for _ in range(chance.randrange(4))}
    return chance.choice([NUMBERS, WORDS, FORMULAS, MODELS, [None, True, False], [[], {}]][kind])


def spoil_entries(chance: Random, data: Any) -> Any:
    """A copy with some entries replaced, removed, renamed, added or exchanged."""
    data = copy.deepcopy(data)
    for _ in range(chance.randint(1, 4)):
        places = list(_places(data))
        if not places:
            break
        parent, key = chance.choice(places)
        action = chance.choice(["replace", "replace", "remove", "rename", "add", "exchange"])
        if action == "replace":
            parent[key] = value(chance)
        elif action == "remove":
            del parent[key]
        elif action == "exchange":
            other, there = chance.choice(places)
            parent[key], other[there] = copy.deepcopy(other[there]), copy.deepcopy(parent[key])
        elif isinstance(parent, dict):
            parent[chance.choice(WORDS)] = parent.pop(key) if action == "rename" else value(chance)
    return data


def _places(data: Any):
    """Every (parent, key) below `data`."""
    entries = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, entry in list(entries):
        yield data, key
        yield from _places(entry)


def spoil_bytes(chance: Random, data: bytes) -> bytes:
    """Bytes that tumbled, are missing, stand twice, or were cut off."""
    for _ in range(chance.randint(1, 6)):
        start = chance.randrange(len(data) + 1)
        end = min(len(data), start + chance.choice([0, 1, 4, 50]))
        insert = chance.choice([b"", chance.randbytes(1), chance.randbytes(8), data[start:end] * 2])
        data = data[:start] + insert + data[end:] if chance.random() < 0.9 else data[:start]
    return data


def spoil_text(chance: Random, text: str) -> bytes:
    """Pieces of YAML where none belong."""
    for _ in range(chance.randint(1, 3)):
        start = chance.randrange(len(text) + 1)
        text = text[:start] + chance.choice(SNIPPETS) + text[start + chance.choice([0, 0, 1, 5, 40]) :]
    return text.encode("utf-8", "surrogatepass")


def scenario(chance: Random, text: str) -> bytes:
    """A scenario's file."""
    kind = chance.randrange(10)
    if kind < 2:
        return spoil_bytes(chance, text.encode())
    if kind < 4:
        return spoil_text(chance, text)
    data = spoil_entries(chance, _loaded(text))
    return _written(data).encode("utf-8", "surrogatepass")


@cache
def _loaded(text: str) -> Any:
    return yaml.safe_load(text)


def _written(data: Any) -> str:
    try:
        return yaml.dump(data, Dumper=_NoAliases, sort_keys=False, allow_unicode=True)
    except ValueError:  # numbers of thousands of digits have no decimal text
        return json.dumps(_without_huge(data), default=str)


def _without_huge(data: Any) -> Any:
    if isinstance(data, dict):
        return {str(key): _without_huge(entry) for key, entry in data.items()}
    if isinstance(data, list):
        return [_without_huge(entry) for entry in data]
    return 10**400 if isinstance(data, int) and data >= HUGE else data


class _NoAliases(getattr(yaml, "CSafeDumper", yaml.SafeDumper)):
    def ignore_aliases(self, data: Any) -> bool:
        return True


def plan(chance: Random, text: str) -> bytes:
    """A plan's JSON."""
    if chance.random() < 0.2:
        return spoil_bytes(chance, text.encode())
    return json.dumps(_without_huge(spoil_entries(chance, json.loads(text)))).encode()


def recording(chance: Random, header: dict, arrays: dict[str, np.ndarray]) -> bytes:
    """A recording's file."""
    kind = chance.randrange(4)
    if kind == 0:
        header = _without_huge(spoil_entries(chance, header))
    elif kind == 1:
        header = header | {"scenario": scenario(chance, header["scenario"]).decode("utf-8", "replace")}
    elif kind == 2:
        arrays = spoil_arrays(chance, arrays)
    text = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
    file = io.BytesIO()
    np.savez_compressed(file, header=text, **arrays)
    return spoil_bytes(chance, file.getvalue()) if kind == 3 else file.getvalue()


def spoil_arrays(chance: Random, arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Other shapes, other types, other numbers; one missing, or one too many."""
    name = chance.choice(sorted(arrays))
    array = arrays[name]
    changes: list[Callable[[], dict[str, np.ndarray]]] = [
        dict,
        lambda: {name: array[: chance.randrange(len(array))]},
        lambda: {name: array.reshape(-1)},
        lambda: {name: array[..., None]},
        lambda: {name: array.astype(chance.choice(["f4", "i2", "c16", "U9", "bool", ">f8", "u8"]))},
        lambda: {name: _with_number(chance, array)},
        lambda: {name: np.zeros((0, *array.shape[1:]), array.dtype)},
        lambda: {name: array, chance.choice(["more", "q/a9", "x" * 5000, "../up"]): array},
    ]
    rest = {key: kept for key, kept in arrays.items() if key != name}
    return rest | chance.choice(changes)()


def _with_number(chance: Random, array: np.ndarray) -> np.ndarray:
    array = array.copy()
    numbers = [-1, -7, 99, 2**62] if array.dtype.kind == "i" else [float("nan"), float("inf"), 1e300, -1e9]
    array.reshape(-1)[chance.randrange(array.size)] = chance.choice(numbers)
    return array
