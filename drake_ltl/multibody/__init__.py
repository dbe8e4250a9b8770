"""From a scenario's model files to Drake: parsing, single-agent kinematics, grasp postures, measured geometry."""

from drake_ltl.multibody.agent_model import AgentModel
from drake_ltl.multibody.measure import MeasuredModels, MeasureGeometry
from drake_ltl.multibody.parsing import AddAgentModel, AddObjectModel

__all__ = ["AddAgentModel", "AddObjectModel", "AgentModel", "MeasureGeometry", "MeasuredModels"]
