"""What many tests share: the paper's second example, its models and its mission, each made once."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# Machines are noisy: how long an example takes proves nothing. Where a failure would stop everybody, the same
# examples are tried every time.
settings.register_profile(
    "drake_ltl", deadline=None, suppress_health_check=[HealthCheck.too_slow], derandomize="CI" in os.environ
)
settings.load_profile("drake_ltl")

EXAMPLES = Path(__file__).parent.parent / "examples"


@pytest.fixture(scope="session")
def examples() -> Path:
    """The folder of example scenarios."""
    return EXAMPLES


@pytest.fixture(scope="session")
def case_ii():
    """Three agents, two objects."""
    from drake_ltl.scenario import load

    return load(EXAMPLES / "case_ii.yaml")


@pytest.fixture(scope="session")
def models(case_ii):
    """Everything measured from the models of case ii."""
    from drake_ltl.multibody import MeasureGeometry

    return MeasureGeometry(case_ii)


@pytest.fixture(scope="session")
def mission(case_ii, models):
    """Case ii planned and placed."""
    from drake_ltl.mission import plan_and_place

    return plan_and_place(case_ii, models)


@pytest.fixture(scope="session")
def program(case_ii, models, mission):
    """Case ii in joint coordinates."""
    from drake_ltl.systems.program import mission_program

    return mission_program(mission, models, case_ii)


@pytest.fixture(scope="session")
def case_ii_run(case_ii, models, mission):
    """Case ii carried out with two rounds of its suffix, so that the loop closes; on a request of marked tests only."""
    from drake_ltl.mission import simulate

    return simulate(mission, case_ii, models, suffix_rounds=2)


@pytest.fixture(scope="session")
def arm_plant():
    """arm_plant(heading, builder=None, time_step=0): a finalized plant of the planar arm, not loaded by the library."""
    from drake_ltl.models import package_xml
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    text = (package_xml().parent / "agents" / "planar_arm.urdf").read_text(encoding="utf-8")
    mount = '<origin xyz="0 0 0.2" rpy="0 0 0"/>'
    assert text.count(mount) == 1

    def make(heading: float, builder=None, time_step: float = 0.0) -> MultibodyPlant:
        plant = MultibodyPlant(time_step) if builder is None else builder.AddSystem(MultibodyPlant(time_step))
        turned = text.replace(mount, f'<origin xyz="0 0 0.2" rpy="0 0 {heading!r}"/>')
        Parser(plant).AddModelsFromString(turned, "urdf")
        plant.Finalize()
        return plant

    return make


YAW_JOINT = {
    'name="mount" type="fixed"': 'name="yaw" type="revolute"',
    '<child link="turret"/>': '<child link="turret"/><axis xyz="0 0 1"/><limit lower="-4" upper="4" effort="100"/>',
    '<link name="turret">': '<link name="turret"><inertial><mass value="0.3"/>'
    '<inertia ixx="0.002" iyy="0.002" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial>',
    "</robot>": '<transmission name="yaw"><type>transmission_interface/SimpleTransmission</type>'
    '<joint name="yaw"/><actuator name="yaw"/></transmission></robot>',
}
"""Text of the planar arm's model, and what takes its place."""


@pytest.fixture(scope="session")
def yaw_joint() -> dict[str, str]:
    """Changes that give the planar arm a yaw joint for its mount; its actuator comes last."""
    return YAW_JOINT


SHUTTLE = """\
name: shuttle
workspace: {radius: 8.0}
regions:
  near: {centre: [-2.7, 0.0, 0.0], radius: 2.5}
  far: {centre: [2.7, 0.5, 0.0], radius: 2.5}
agents:
  a1:
    model: package://drake_ltl_models/agents/planar_arm.urdf
    position: [-2.5, 0.0]
    power: 1
    spec: "GF near & GF far"
"""


@pytest.fixture(scope="session")
def shuttle_text() -> str:
    """One agent between two regions: the quickest mission that moves."""
    return SHUTTLE


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Fast tests first: whole missions come last."""
    items.sort(key=lambda item: item.get_closest_marker("mission") is not None)
