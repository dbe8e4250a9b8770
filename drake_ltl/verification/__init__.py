"""Verdicts: whether a run did what its scenario demands, from the recording alone.

Nothing here knows the planner, the controllers or the simulator, so that their mistakes cannot excuse themselves.
`verify` reads top to bottom: what stands where (`spans`, `expected`, `roles`), what the models make of the recorded
joints (`mechanics`), then one file for each thing that must hold.
"""

from drake_ltl.verification.judge import verify
from drake_ltl.verification.table import verdict_table
from drake_ltl.verification.verdict import Verdict, to_json
from drake_ltl.verification.violations import Violation

__all__ = ["Verdict", "Violation", "to_json", "verdict_table", "verify"]
