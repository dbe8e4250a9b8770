"""YAML as plain maps, lists, texts and numbers: the subset that cannot surprise.

Refused are duplicate keys (one of them would be lost), anchors and aliases (a few of them expand to
gigabytes), tags (an unquoted formula that begins with `!` is one) and texts too long to be a scenario. Dates
and merge keys are read as text, `1e3` is a number as in YAML 1.2.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import yaml

from drake_ltl.errors import InvalidInputError, Mistake

MAX_BYTES = 100_000
"""A scenario is a page or two of text; more is a mistake, and would take long to parse."""
MAX_DEPTH = 50
"""Maps and lists inside each other."""
HUGE = 10**sys.int_info.default_max_str_digits
"""What stands for whole numbers of more digits."""

_KEPT_TAGS = {f"tag:yaml.org,2002:{kind}" for kind in ("null", "bool", "int", "float")}
_REMEDIES = {
    "'\\t'": "indent with spaces, not with tabs",
    "stands twice": "write each key of a map once",
    "mapping values are not allowed": "write a colon after every key, in the line before too; quote texts with colons",
    "expected ':'": "write a colon after every key",
    "expected ',' or": "close every bracket, and write commas between entries",
    "end of stream": "close every quote",
    "expected <block end>": "indent all keys of a map alike, and close quotes and brackets in the lines before",
    "": "write plain values, and formulas in double quotes",
}
"""Part of what is wrong -> what would be right; the first that fits."""


class _PlainLoader(yaml.SafeLoader):
    """SafeLoader without aliases, tags, duplicate keys and implicit dates."""

    yaml_implicit_resolvers = {  # noqa: RUF012 (PyYAML's own class attribute)
        first: [(tag, pattern) for tag, pattern in resolvers if tag in _KEPT_TAGS]
        for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
    }

    _depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        event = self.peek_event()
        if isinstance(event, yaml.AliasEvent) or event.anchor is not None:
            raise yaml.MarkedYAMLError(
                problem=f"anchors and aliases (&{event.anchor}, *{event.anchor}) are not read here",
                problem_mark=event.start_mark,
            )
        if event.tag is not None:  # `spec: ! pi3` would lose its negation without a murmur
            raise yaml.MarkedYAMLError(problem=f"the tag {event.tag} is not read here", problem_mark=event.start_mark)
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise RecursionError
        node = super().compose_node(parent, index)
        self._depth -= 1
        return node

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:
        seen = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if not isinstance(key, str | int | float | None):
                raise yaml.MarkedYAMLError(problem="a key is not text", problem_mark=key_node.start_mark)
            if key in seen:
                raise yaml.MarkedYAMLError(
                    problem=f"the key {key!r} stands twice in one map", problem_mark=key_node.start_mark
                )
            seen.add(key)
        return super().construct_mapping(node, deep=deep)


def _whole_number(loader: _PlainLoader, node: yaml.ScalarNode) -> int:
    """Also of more digits than Python turns into a number: whoever wants a number then says that it is too large."""
    try:
        return loader.construct_yaml_int(node)
    except ValueError:
        if len(node.value) < sys.int_info.default_max_str_digits:
            raise
        return -HUGE if node.value.startswith("-") else HUGE


_PlainLoader.add_constructor("tag:yaml.org,2002:int", _whole_number)
_PlainLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"[-+]?[0-9]+(\.[0-9]*)?[eE][-+]?[0-9]+$"), list("-+0123456789")
)


def read_text(path: Path) -> str:
    """The text of the file at `path`. Raises InvalidInputError when it cannot be read or is not UTF-8."""
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        reason = getattr(error, "strerror", None) or str(error)
        raise _refusal(str(path), f"cannot be read ({reason})", "name a scenario file") from error
    if len(data) > MAX_BYTES:
        raise _refusal(str(path), f"is longer than {MAX_BYTES} bytes", "name a scenario file")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise _refusal(str(path), f"is not UTF-8 text ({error.reason} at byte {error.start})") from error


def parse(text: str, source_name: str) -> Any:
    """What the YAML `text` says; `source_name` is how messages call it. Raises InvalidInputError."""
    if len(text) > MAX_BYTES:
        raise _refusal(source_name, f"is longer than {MAX_BYTES} characters", "name a scenario file")
    try:
        return yaml.load(text, Loader=_PlainLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = f" at line {mark.line + 1}, column {mark.column + 1}" if mark else ""
        problem = " ".join(f"{error.context or ''} {error.problem or ''}".split())
        remedy = next(remedy for part, remedy in _REMEDIES.items() if part in problem)
        raise _refusal(source_name, f"{problem}{place}", remedy) from error
    except yaml.YAMLError as error:
        raise _refusal(source_name, " ".join(str(error).split())) from error
    except RecursionError as error:
        raise _refusal(source_name, "is nested too deeply", "write three or four levels") from error
    except (ValueError, OverflowError) as error:  # a number that no number type takes
        raise _refusal(source_name, f"holds a number that cannot be read ({error})") from error


def _refusal(source: str, what: str, remedy: str = "write YAML as in the examples") -> InvalidInputError:
    where = source if source.isprintable() else repr(source)
    return InvalidInputError([Mistake(where, what, remedy)])
