"""A sweep's summary for a terminal, and as JSON."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from typing import Any

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from drake_ltl.sweep.outcome import Outcome, outcome_to_json
from drake_ltl.sweep.statistics import CONFIDENCE, Quantity, Share, Summary
from drake_ltl.verification.table import CLEARANCE_NAMES

MOST_REASONS = 20
"""Lines about runs that are not satisfied; the journal has all."""
_DASH = "\N{EN DASH}"


def summary_table(summary: Summary, name: str, runs: int) -> RenderableType:
    """Headline, the runs that are not satisfied with their reasons, and all quantities.

    Args:
        name: the scenario's.
        runs: how many there are to be.
    """
    done = len(summary.outcomes)
    word, style = ("ALL SATISFIED", "bold green") if done and not summary.unsatisfied else ("NOT ALL", "bold red")
    word, style = (word, style) if done == runs else ("UNFINISHED", "bold yellow")
    head = Text.assemble((word, style), f"  {name}, {done} of {runs} runs")
    return Group(head, _shares(summary), *_reasons(summary), _quantities(summary))


def _shares(summary: Summary) -> Table:
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1))
    table.add_column("runs", no_wrap=True)
    table.add_column("number", justify="right", no_wrap=True)
    table.add_column("share", justify="right", no_wrap=True)
    table.add_column(f"{CONFIDENCE:.0%} interval", no_wrap=True)
    table.add_row("satisfied", *_share(summary.satisfied))
    for status, count in list(summary.statuses.items())[1:]:
        if count:
            table.add_row(status, f"{count}", f"{count / len(summary.outcomes):.1%}", "")
    table.add_row("collided, of those simulated", *_share(summary.collided))
    return table


def _share(share: Share) -> tuple[str, str, str]:
    if not share.of:
        return "0", _DASH, ""
    return f"{share.count}", f"{share.count / share.of:.1%}", f"{share.low:.1%} to {share.high:.1%}"


def _reasons(summary: Summary) -> Iterator[Text]:
    for outcome in summary.unsatisfied[:MOST_REASONS]:
        yield Text(f"  run {outcome.run}, {outcome.status}: {outcome.reason}", style="red")
    more = len(summary.unsatisfied) - MOST_REASONS
    if more > 0:
        yield Text(f"  and {more} more", style="red")


def _quantities(summary: Summary) -> Table:
    """Beside the least and the greatest stands the run that has it."""
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1))
    table.add_column("of each run", no_wrap=True)
    table.add_column("runs", justify="right", no_wrap=True)
    for column in ("least", "median", "mean"):
        table.add_column(column, justify="right", no_wrap=True)
    table.add_column(f"{CONFIDENCE:.0%} interval", no_wrap=True)
    table.add_column("greatest", justify="right", no_wrap=True)
    for row in summary.quantities:
        table.add_row(*_row(row))
    return table


def _row(row: Quantity) -> tuple[str, ...]:
    unit, scale = _shown_unit(row)
    name = f"clearance {CLEARANCE_NAMES[row.name]}" if row.name in CLEARANCE_NAMES else row.name

    def number(value: float) -> str:
        return f"{scale * value:.3g}"

    return (
        f"{name}, {unit}" if unit else name,
        f"{row.count}",
        f"{number(row.least)} ({row.least_run})",
        number(row.median),
        number(row.mean),
        "" if row.mean_low is None else f"{number(row.mean_low)} to {number(row.mean_high)}",
        f"{number(row.greatest)} ({row.greatest_run})",
    )


def _shown_unit(row: Quantity) -> tuple[str, float]:
    """The unit for people, and what numbers are multiplied with."""
    if row.unit == "rad":
        return "degrees", math.degrees(1.0)
    if row.unit == "m" and max(abs(row.least), abs(row.greatest)) < 0.01:
        return "mm", 1e3
    return row.unit, 1.0


def summary_to_json(summary: Summary, header: Mapping[str, Any], runs: int) -> dict[str, Any]:
    """All of the summary, with the header of the journal and every run that is not satisfied."""
    return {
        "header": dict(header),
        "runs": runs,
        "done": len(summary.outcomes),
        "statuses": summary.statuses,
        "satisfied": dataclasses.asdict(summary.satisfied),
        "collided": dataclasses.asdict(summary.collided),
        "confidence": CONFIDENCE,
        "quantities": [dataclasses.asdict(row) for row in summary.quantities],
        "unsatisfied": [_without_time(outcome) for outcome in summary.unsatisfied],
    }


def _without_time(outcome: Outcome) -> dict[str, Any]:
    """The same whenever the sweep is done."""
    return {key: value for key, value in outcome_to_json(outcome).items() if key != "wall_seconds"}
