"""Models that scenarios name, added to a plant; what cannot be used is said with its key path."""

from __future__ import annotations

import re

import numpy as np
import pytest
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant

from drake_ltl.errors import InvalidInputError
from drake_ltl.multibody import AddAgentModel, AddObjectModel, AgentModel
from drake_ltl.multibody.object_model import ObjectModel
from drake_ltl.multibody.postures import grasp_configurations
from drake_ltl.scenario.model import Agent, TransportObject
from drake_ltl.scenario.model_files import resolve

ARM, CRATE = "agents/planar_arm.urdf", "objects/crate.sdf"


def the_mistake(add, member):
    plant = MultibodyPlant(0.0)
    with pytest.raises(InvalidInputError) as caught:
        add(plant, member)
    (mistake,) = caught.value.mistakes
    assert "\n" not in str(mistake)
    return mistake


@pytest.mark.parametrize("frame", ["grasp", "bounding_centre"])
@pytest.mark.parametrize("heading", [0.0, 0.7])
def test_an_agent_needs_its_frames(changed_model, make_agent, frame, heading):
    path = changed_model(ARM, {f'<frame name="{frame}"': '<frame name="other"'})
    mistake = the_mistake(AddAgentModel, make_agent(heading, path))
    assert mistake.where == "agents.a1.model"
    assert f"no frame '{frame}'" in mistake.what


def test_an_agent_needs_an_actuator_for_every_joint(changed_model, make_agent):
    path = changed_model(ARM, {})
    text, _, _ = path.read_text(encoding="utf-8").partition('<transmission name="q2">')
    path.write_text(text + "</robot>", encoding="utf-8")
    mistake = the_mistake(AddAgentModel, make_agent(0.0, path))
    assert mistake.where == "agents.a1.model"
    assert "4 degrees of freedom but 3 actuators" in mistake.what


@pytest.mark.parametrize("change", [{'name="mount" type="fixed"': 'name="neck" type="fixed"'}])
def test_a_heading_needs_a_mount(changed_model, make_agent, change):
    path = changed_model(ARM, change)
    mistake = the_mistake(AddAgentModel, make_agent(1.0, path))
    assert mistake.where == "agents.a1.heading"
    assert "cannot be turned by 1 rad" in mistake.what
    assert "'mount'" in mistake.what
    assert "agents that state no heading" in mistake.what  # it need not be the file's
    assert "heading: 0 for a1" in mistake.remedy
    AddAgentModel(MultibodyPlant(0.0), make_agent(0.0, path))  # without a heading it may be called as it likes


def test_an_arm_with_a_yaw_joint_turns_itself(changed_model, yaw_joint, make_agent, make_object):
    """It needs no mount, and grasps along its heading with the joint turned."""
    agent = make_agent(1.0, changed_model(ARM, yaw_joint))
    model, crate = AgentModel(agent), ObjectModel(make_object())
    assert model.joint_names == ("x", "y", "yaw", "q1", "q2")
    plus, minus = grasp_configurations(model, crate.X_OG, crate.height)
    along = np.array([np.cos(1.0), np.sin(1.0), 0.0])
    for grasp, sign in ((plus, 1.0), (minus, -1.0)):
        np.testing.assert_allclose(model.grasp_pose(grasp.q).rotation().matrix()[:, 2], sign * along, atol=1e-3)
        assert sign * (grasp.q[:2] @ along[:2]) < 0.0  # the base stands behind the gripper


@pytest.mark.parametrize("change", [{"0 0 1": "0 1 0"}, {"revolute": "prismatic"}], ids=["not upright", "no turn"])
def test_another_joint_is_no_yaw(changed_model, yaw_joint, make_agent, change):
    changes = {old: new.replace(*next(iter(change.items()))) for old, new in yaw_joint.items()}
    assert the_mistake(AddAgentModel, make_agent(1.0, changed_model(ARM, changes))).where == "agents.a1.heading"


BROKEN = {
    "not closed": "<robot name='r'><link name='base'>",
    "another language": "links: [base]",
    "empty": "",
    "unknown parent": "<robot name='r'><link name='b'/><joint name='mount' type='fixed'>"
    "<parent link='nobody'/><child link='b'/></joint></robot>",
    "an origin that is none": "<robot name='r'><link name='a'/><link name='b'/><joint name='mount' type='fixed'>"
    "<origin rpy='0 0 east'/><parent link='a'/><child link='b'/></joint></robot>",
    "an origin too short": "<robot name='r'><link name='a'/><link name='b'/><joint name='mount' type='fixed'>"
    "<origin rpy='0 0'/><parent link='a'/><child link='b'/></joint></robot>",
    "not text": b"\xff\xfe\x00<robot/>",
}


@pytest.mark.parametrize("heading", [0.0, 0.7])
@pytest.mark.parametrize("content", BROKEN.values(), ids=BROKEN)
def test_an_agent_must_parse(tmp_path, make_agent, content, heading):
    path = tmp_path / "robot.urdf"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    mistake = the_mistake(AddAgentModel, make_agent(heading, path))
    assert mistake.where == "agents.a1.model"
    assert "robot.urdf" in mistake.what


def test_messages_name_the_file_and_its_line(changed_model, make_agent, make_object):
    for heading in (0.0, 0.7):
        path = changed_model(ARM, {'name="q1" type="revolute"': 'name="q1" type="floaty"'})
        line = 1 + path.read_text(encoding="utf-8").partition("floaty")[0].count("\n")
        mistake = the_mistake(AddAgentModel, make_agent(heading, path))
        assert f"planar_arm.urdf:{line}: " in mistake.what
        assert "literal" not in mistake.what
    path = changed_model(CRATE, {"</link>": "<boxx/></link>"})
    mistake = the_mistake(AddObjectModel, make_object(path))
    assert mistake.what.startswith("crate.sdf does not parse: crate.sdf:")
    assert str(path.parent) not in mistake.what


def test_models_that_nothing_could_touch(changed_model, make_agent, make_object):
    for name, make, load in ((ARM, make_agent, AgentModel), (CRATE, make_object, ObjectModel)):
        path = changed_model(name, {})
        text = re.sub("<collision.*?</collision>", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
        path.write_text(text, encoding="utf-8")
        with pytest.raises(InvalidInputError, match="has no collision geometry"):
            load(make(model=path))


@pytest.mark.parametrize("content", [*(BROKEN[k] for k in ("not closed", "another language", "empty", "not text"))])
@pytest.mark.parametrize("suffix", [".sdf", ".urdf", ".txt", ""])
def test_an_object_must_parse(tmp_path, make_object, content, suffix):
    path = tmp_path / f"thing{suffix}"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    mistake = the_mistake(AddObjectModel, make_object(path))
    assert mistake.where == "objects.o1.model"
    assert "does not parse" in mistake.what


@pytest.mark.parametrize("heading", [0.0, 0.7])
def test_models_that_are_not_there(make_agent, make_object, heading):
    assert the_mistake(AddAgentModel, make_agent(heading, "/nowhere/arm.urdf")).where == "agents.a1.model"
    assert the_mistake(AddObjectModel, make_object("/nowhere/crate.sdf")).where == "objects.o1.model"


def test_an_object_needs_its_ring(changed_model, make_object):
    path = changed_model(CRATE, {'<frame name="grasp_ring"': '<frame name="ring"'})
    mistake = the_mistake(AddObjectModel, make_object(path))
    assert mistake.where == "objects.o1.model"
    assert "'grasp_ring'" in mistake.what


def test_an_object_is_one_link(changed_model, make_object):
    path = changed_model(CRATE, {"</model>": "<link name='lid'/></model>"})
    mistake = the_mistake(AddObjectModel, make_object(path))
    assert mistake.where == "objects.o1.model"
    assert "several links" in mistake.what


def test_members_go_by_their_own_names(make_agent, make_object):
    plant = MultibodyPlant(0.0)
    assert plant.GetModelInstanceName(AddAgentModel(plant, make_agent())) == "a1"
    assert plant.GetModelInstanceName(AddObjectModel(plant, make_object())) == "o1"


def test_heading_turns_the_arm_and_leaves_the_base(make_agent):
    """The gripper goes round the base; x and y stay those of the world."""
    q = np.array([1.0, 2.0, 1.2, 0.3])
    poses = {}
    for heading in (0.0, 0.9):
        plant = MultibodyPlant(0.0)
        AddAgentModel(plant, make_agent(heading))
        plant.Finalize()
        context = plant.CreateDefaultContext()
        plant.SetPositions(context, q)
        poses[heading] = {
            name: plant.GetFrameByName(name).CalcPoseInWorld(context) for name in ("base", "grasp", "bounding_centre")
        }
    assert poses[0.9]["base"].IsExactlyEqualTo(poses[0.0]["base"])
    c, s = np.cos(0.9), np.sin(0.9)
    Rz = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    base = np.array([1.0, 2.0, 0.0])
    for name in ("grasp", "bounding_centre"):
        before, after = poses[0.0][name], poses[0.9][name]
        np.testing.assert_allclose(after.translation() - base, Rz @ (before.translation() - base), atol=1e-12)
        np.testing.assert_allclose(after.rotation().matrix(), Rz @ before.rotation().matrix(), atol=1e-12)


def test_heading_adds_to_the_mount_s_own_angles(changed_model, make_agent):
    mount = '<origin xyz="0 0 0.2" rpy="0 0 0"/>'
    path = changed_model(ARM, {mount: mount.replace('rpy="0 0 0"', 'rpy="0.1 0.2 0.3"')})
    plant = MultibodyPlant(0.0)
    AddAgentModel(plant, make_agent(0.5, path))
    plant.Finalize()
    X_BT = plant.GetJointByName("mount").frame_on_parent().GetFixedPoseInBodyFrame()
    np.testing.assert_allclose(X_BT.rotation().ToRollPitchYaw().vector(), [0.1, 0.2, 0.8], atol=1e-12)


def test_headings_may_be_given_without_an_origin(changed_model, make_agent):
    path = changed_model(ARM, {'<origin xyz="0 0 0.2" rpy="0 0 0"/>': ""})
    plant = MultibodyPlant(0.0)
    AddAgentModel(plant, make_agent(0.5, path))
    plant.Finalize()
    X_BT = plant.GetJointByName("mount").frame_on_parent().GetFixedPoseInBodyFrame()
    np.testing.assert_allclose(X_BT.rotation().ToRollPitchYaw().vector(), [0.0, 0.0, 0.5], atol=1e-12)


def test_an_object_s_origin_is_its_centre_of_mass(tmp_path):
    text = resolve("package://drake_ltl_models/objects/crate.sdf").read_text()
    assert "<mass>" in text
    path = tmp_path / "lopsided.sdf"
    path.write_text(text.replace("<mass>", "<pose>0.1 0 0 0 0 0</pose><mass>", 1))
    plant = MultibodyPlant(0.0)
    with pytest.raises(InvalidInputError, match=r"objects\.o1\.model: the centre of mass .* origin"):
        AddObjectModel(plant, TransportObject("o1", str(path), (0.0, 0.0), 1.0))


@pytest.mark.parametrize("heading", [0.0, 1.0])
def test_meshes_beside_the_file_are_found(tmp_path, heading):
    (tmp_path / "part.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    text = resolve("package://drake_ltl_models/agents/planar_arm.urdf").read_text()
    visual = '<visual name="part"><geometry><mesh filename="part.obj"/></geometry></visual></robot>'
    link = f'<link name="part">{visual[:-8]}</link><joint name="part" type="fixed"><parent link="base"/>'
    path = tmp_path / "arm.urdf"
    path.write_text(text.replace("</robot>", f'{link}<child link="part"/></joint></robot>'))
    plant = MultibodyPlant(0.0)
    scene_graph = SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    AddAgentModel(plant, Agent("a1", str(path), (0.0, 0.0), heading, 1.0))
    names = [scene_graph.model_inspector().GetName(i) for i in scene_graph.model_inspector().GetAllGeometryIds()]
    assert any(name.endswith("part") for name in names)
