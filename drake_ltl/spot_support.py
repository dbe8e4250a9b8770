"""The one place that imports Spot, so that only what needs temporal logic pays for it or misses it."""

from __future__ import annotations

import importlib
import platform
import sys
import warnings
from types import ModuleType

from drake_ltl.errors import MissingDependencyError


def require_spot() -> ModuleType:
    """The module `spot`.

    Raises:
        MissingDependencyError: Spot is not installed; the message says how to get it on this platform.
    """
    try:
        spot = sys.modules.get("spot") or _import_quietly()
    except ImportError as error:
        raise MissingDependencyError(f"Spot cannot be imported ({error}). {_how_to_install()}") from error
    if not hasattr(spot, "parse_infix_psl"):
        place = getattr(spot, "__file__", None)
        raise MissingDependencyError(
            f"The module `spot` at {place} is not the library of temporal logic. {_how_to_install()}"
        )
    return spot


def _import_quietly() -> ModuleType:
    """Spot's bindings warn while they load, and crash the process where warnings are errors."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        return importlib.import_module("spot")


def _how_to_install() -> str:
    """Wheels exist for Linux on x86-64 only; conda-forge builds Spot for the other platforms."""
    system, machine = platform.system(), platform.machine()
    if (system, machine) == ("Linux", "x86_64"):
        return "Install it with `pip install spottl`."
    return (
        f"There is no wheel for {system} on {machine}; install it with "
        "`conda install -c conda-forge spot` and run drake_ltl in that environment."
    )
