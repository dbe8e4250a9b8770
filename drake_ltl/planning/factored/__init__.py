"""Exact planning for larger teams: transitions are never listed, interchangeable agents are merged."""

from drake_ltl.planning.factored.crowds import crowds
from drake_ltl.planning.factored.search import FactoredSearch, check_product, check_size
from drake_ltl.planning.factored.states import MergedStates

__all__ = ["FactoredSearch", "MergedStates", "check_product", "check_size", "crowds"]
