"""The problem: scenario files, read whole into immutable data, with every mistake found."""

from drake_ltl.scenario.model import Agent, Region, Scenario, TransportObject
from drake_ltl.scenario.reader import load, loads

__all__ = ["Agent", "Region", "Scenario", "TransportObject", "load", "loads"]
