"""Multirobot navigation functions: relations, obstacle function, potential and its gradient. Pure numpy."""

from drake_ltl.navigation.mover_potential import MoverPotential
from drake_ltl.navigation.potential import NavigationFunction
from drake_ltl.navigation.realisable import RelationSets, number_of_factors, realisable_sets
from drake_ltl.navigation.relations import Apart, Inside, Label, Relations
from drake_ltl.navigation.shaping import Logarithmic, PaperPhi, PseudoHuber, Shaping, check_shaping, shaping_from
from drake_ltl.navigation.step import (
    Reach,
    RegionBall,
    StaticBody,
    StepRelations,
    Transport,
    Traveller,
    step_relations,
)

__all__ = [
    "Apart",
    "Inside",
    "Label",
    "Logarithmic",
    "MoverPotential",
    "NavigationFunction",
    "PaperPhi",
    "PseudoHuber",
    "Reach",
    "RegionBall",
    "RelationSets",
    "Relations",
    "Shaping",
    "StaticBody",
    "StepRelations",
    "Transport",
    "Traveller",
    "check_shaping",
    "number_of_factors",
    "realisable_sets",
    "shaping_from",
    "step_relations",
]
