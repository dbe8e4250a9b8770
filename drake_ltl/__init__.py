"""From linear temporal logic over robots and objects to a proven plan and a verified Drake simulation.

    import drake_ltl

    scenario = drake_ltl.load("patrol")      # a file, or the name of an example
    plan = drake_ltl.plan(scenario)
    run = drake_ltl.simulate(scenario, plan)
    print(drake_ltl.verify(run).satisfied)

Names are loaded when they are first used: `import drake_ltl` itself loads nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from drake_ltl.api import load as load
    from drake_ltl.api import own_plan as own_plan
    from drake_ltl.api import plan as plan
    from drake_ltl.api import simulate as simulate
    from drake_ltl.api import verify as verify
    from drake_ltl.execution.recording import Recording as Recording
    from drake_ltl.planning.plan import Plan as Plan
    from drake_ltl.scenario import Scenario as Scenario
    from drake_ltl.scenario import loads as loads
    from drake_ltl.verification import Verdict as Verdict

__version__ = "0.1.0"

_HOMES = {
    "load": "api",
    "own_plan": "api",
    "plan": "api",
    "simulate": "api",
    "verify": "api",
    "loads": "scenario",
    "Scenario": "scenario",
    "Plan": "planning.plan",
    "Recording": "execution.recording",
    "Verdict": "verification",
}

__all__ = ["Plan", "Recording", "Scenario", "Verdict", "load", "loads", "own_plan", "plan", "simulate", "verify"]


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
