"""Drake's messages that do not concern rigid bodies are kept from people; all others pass."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def without_half_space_warning() -> Iterator[None]:
    """A context of a scene with a half-space warns that deformable bodies would ignore it; there are none here."""
    logger = logging.getLogger("drake")

    def other(record: logging.LogRecord) -> bool:
        return "half spaces are not currently supported for deformable contact" not in record.getMessage()

    logger.addFilter(other)
    try:
        yield
    finally:
        logger.removeFilter(other)
