"""Assembly of drake_ltl's systems into Drake diagrams."""

from drake_ltl.diagrams.mission_diagram import MakeMissionDiagram, MissionDiagram
from drake_ltl.diagrams.transport_plant import AddTransportPlant, TransportPlant

__all__ = ["AddTransportPlant", "MakeMissionDiagram", "MissionDiagram", "TransportPlant"]
