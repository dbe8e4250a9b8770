"""Multirobot navigation functions: relations, obstacle function, potential and its gradient. Pure numpy."""

from drake_ltl.navigation.potential import NavigationFunction
from drake_ltl.navigation.relations import Apart, Inside, Label, Relations
from drake_ltl.navigation.shaping import Logarithmic, PaperPhi, PseudoHuber, Shaping
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
    "NavigationFunction",
    "PaperPhi",
    "PseudoHuber",
    "Reach",
    "RegionBall",
    "Relations",
    "Shaping",
    "StaticBody",
    "StepRelations",
    "Transport",
    "Traveller",
    "step_relations",
]
