"""How far a search has come: the best cost, the best bound and the time, shared by those who improve them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Progress:
    """What is known at some moment."""

    seconds: float
    cost: float | None
    """Of the best plan so far."""
    lower_bound: float
    """No plan of any length costs less."""

    @property
    def gap(self) -> float | None:
        """What a cheaper plan could save at most, as a share of the cost; None without a plan."""
        if self.cost is None:
            return None
        return max(0.0, 1.0 - self.lower_bound / self.cost) if self.cost else 0.0


Report = Callable[[Progress], None]

_SAME = 1e-9
"""Relative difference of costs that are sums of the same numbers."""


@dataclass
class Standing:
    """The only state that the search for plans and the search for bounds share."""

    time_limit: float
    """For all of it [s]."""
    report: Report | None = None
    cost: float | None = None
    lower_bound: float = 0.0
    stopped: bool = False
    """Nobody needs better bounds any more."""
    _began: float = field(default_factory=time.perf_counter)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    @property
    def seconds(self) -> float:
        """Time since the beginning."""
        return time.perf_counter() - self._began

    @property
    def left(self) -> float:
        """Time until the end; negative after it."""
        return self.time_limit - self.seconds

    @property
    def proven(self) -> bool:
        """Whether the best plan is as good as any."""
        return self.cost is not None and self.cost <= self.lower_bound * (1.0 + _SAME)

    def raise_bound(self, bound: float) -> None:
        """A bound has been proven."""
        with self._lock:
            if bound > self.lower_bound:
                self.lower_bound = bound
                self._tell()

    def improve(self, cost: float) -> None:
        """A plan has been found."""
        with self._lock:
            if self.cost is None or cost < self.cost:
                self.cost = cost
                self._tell()

    def _tell(self) -> None:
        if self.report:
            self.report(Progress(self.seconds, self.cost, self.lower_bound))
