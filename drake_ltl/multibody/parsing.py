"""Adds a scenario's agents and objects to a MultibodyPlant."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.dom import minidom
from xml.parsers.expat import ExpatError

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.models import package_xml
from drake_ltl.multibody import drive_urdf
from drake_ltl.scenario.model import Agent, TransportObject
from drake_ltl.scenario.model_access import package_of
from drake_ltl.scenario.model_files import is_drive, resolve

GRASP_FRAME = "grasp"
"""Frame of an agent's URDF at the gripper's tip, z forward: the end-effector frame {E}."""
CENTRE_FRAME = "bounding_centre"
"""Frame of an agent's URDF at the centre c_i of its bounding sphere."""
MOUNT_JOINT = "mount"
"""Fixed joint of an agent's URDF whose yaw is the scenario's `heading`."""
RING_FRAME = "grasp_ring"
"""Frame of an object's SDF: one grasp frame; rotating it about the object's z axis gives all others."""
COM_TOLERANCE = 1e-4
"""How far an object's centre of mass may be from its origin [m]."""
HANDLE_PREFIX = "handle"
"""Collision geometries of an object that grippers are meant to touch begin with this."""


def AddAgentModel(plant: MultibodyPlant, agent: Agent) -> ModelInstanceIndex:
    """Adds the agent's URDF under its own name, its arm turned by its heading.

    The heading is the yaw of the fixed joint `mount`. An arm without one that has a yaw joint is not turned: it turns
    itself to grasp along the heading. A differential drive stands on the joints of `drive_urdf` and has no gripper.

    Raises:
        InvalidInputError: the file cannot be parsed, lacks the frames `grasp` and `bounding_centre`, has a
            joint without an actuator, or has a heading but neither a fixed joint `mount` nor a yaw joint.
    """
    path = resolve(agent.model)
    actuators_before = plant.num_actuators()
    has_arm = not has_wheels(agent)
    instance = parse_model(plant, f"agents.{agent.name}.model", path, agent.name, _edited(agent, path, has_arm))
    for frame in (GRASP_FRAME, CENTRE_FRAME) if has_arm else (CENTRE_FRAME,):
        if not plant.HasFrameNamed(frame, instance):
            raise InvalidInputError(
                [
                    Mistake(
                        f"agents.{agent.name}.model",
                        f"{path.name} has no frame {frame!r}",
                        f'add <frame name="{frame}" link="..." xyz="..." rpy="..."/> to it',
                    )
                ]
            )
    joints = [plant.get_joint(index) for index in plant.GetJointIndices(instance)]
    dofs = sum(joint.num_velocities() for joint in joints) - (0 if has_arm else len(drive_urdf.FREE_JOINTS))
    actuators = plant.num_actuators() - actuators_before
    if actuators != dofs:
        raise InvalidInputError(
            [
                Mistake(
                    f"agents.{agent.name}.model",
                    f"{path.name} has {dofs} degrees of freedom but {actuators} actuators",
                    "give every movable joint a <transmission> with an actuator",
                )
            ]
        )
    return instance


def AddObjectModel(plant: MultibodyPlant, obj: TransportObject) -> ModelInstanceIndex:
    """Adds the object's SDF (one free body) under its own name.

    Raises:
        InvalidInputError: the file cannot be parsed, has more than one link, lacks the frame `grasp_ring`, or its
            centre of mass is not at its origin.
    """
    path = resolve(obj.model)
    where = f"objects.{obj.name}.model"
    instance = parse_model(plant, where, path, obj.name)
    if len(plant.GetBodyIndices(instance)) != 1:
        raise InvalidInputError([Mistake(where, f"{path.name} has several links", "an object is one rigid link")])
    body = plant.get_body(plant.GetBodyIndices(instance)[0])
    if np.linalg.norm(body.default_com()) > COM_TOLERANCE:
        raise InvalidInputError(
            [
                Mistake(
                    where,
                    f"the centre of mass in {path.name} is not at the link's origin but at {body.default_com()}",
                    "put the link's origin there: it is the frame {O} of the control laws",
                )
            ]
        )
    if not plant.HasFrameNamed(RING_FRAME, instance):
        raise InvalidInputError(
            [
                Mistake(
                    where,
                    f"{path.name} has no frame {RING_FRAME!r}",
                    "add the grasp frame at azimuth 0, its z axis pointing towards the object",
                )
            ]
        )
    return instance


def has_wheels(agent: Agent) -> bool:
    """Whether the agent is a differential drive. Raises InvalidInputError if its file is no URDF."""
    path = resolve(agent.model)
    try:
        return is_drive(path)
    except (OSError, ValueError) as error:
        raise _unparsable(f"agents.{agent.name}.model", path, error) from error


def _edited(agent: Agent, path: Path, has_arm: bool) -> str:
    """The URDF's text with the heading written into the yaw of its `mount` joint; a drive's on joints."""
    where = f"agents.{agent.name}.model"
    try:
        text = path.read_text(encoding="utf-8")
        document = minidom.parseString(text)  # unlike ElementTree it keeps the prefix of Drake's tags
        if not has_arm:
            drive_urdf.on_joints(document, _centre_of_mass(agent, path))
        elif agent.heading != 0.0:
            _turn(agent, path, document)
    except (OSError, ExpatError, ValueError) as error:
        raise _unparsable(where, path, error) from error
    _anchor_files(document, path.parent)
    robot = document.documentElement.toxml()
    return "\n" * (text.rstrip().count("\n") - robot.count("\n")) + robot  # messages then name the file's lines


def _centre_of_mass(agent: Agent, path: Path) -> float:
    """Its height when the base's origin is the world's [m]."""
    plant = MultibodyPlant(0.0)
    parse_model(plant, f"agents.{agent.name}.model", path, agent.name)
    plant.Finalize()
    return float(plant.CalcCenterOfMassPositionInWorld(plant.CreateDefaultContext())[2])


def _turn(agent: Agent, path: Path, document: minidom.Document) -> None:
    for joint in document.getElementsByTagName("joint"):
        if joint.getAttribute("name") == MOUNT_JOINT and joint.getAttribute("type") == "fixed":
            origins = joint.getElementsByTagName("origin")
            origin = origins[0] if origins else joint.appendChild(document.createElement("origin"))
            roll, pitch, yaw = _numbers(origin.getAttribute("rpy"))
            origin.setAttribute("rpy", f"{roll!r} {pitch!r} {yaw + agent.heading!r}")
            return
    if not any(map(_is_yaw, document.getElementsByTagName("joint"))):
        raise InvalidInputError(
            [
                Mistake(
                    f"agents.{agent.name}.heading",
                    f"the arm cannot be turned by {agent.heading:.6g} rad: {path.name} has neither a fixed joint "
                    f"{MOUNT_JOINT!r} below its arm nor a yaw joint (agents that state no heading get theirs from "
                    "their place in the file)",
                    f"write heading: 0 for {agent.name}, or call the joint that carries the arm {MOUNT_JOINT!r}",
                )
            ]
        )


def _is_yaw(joint: minidom.Element) -> bool:
    """Whether a joint turns about the vertical, as seen from an upright parent."""
    if joint.getAttribute("type") not in ("revolute", "continuous"):
        return False
    axes, origins = joint.getElementsByTagName("axis"), joint.getElementsByTagName("origin")
    x, y, z = _numbers(axes[0].getAttribute("xyz"), "1 0 0") if axes else (1.0, 0.0, 0.0)
    roll, pitch, _ = _numbers(origins[0].getAttribute("rpy")) if origins else (0.0, 0.0, 0.0)
    return (x, y, roll, pitch) == (0.0, 0.0, 0.0, 0.0) and z != 0.0


def _numbers(text: str, default: str = "0 0 0") -> tuple[float, float, float]:
    """Raises ValueError unless there are three."""
    a, b, c = (float(number) for number in (text or default).split())
    return a, b, c


def _anchor_files(document: minidom.Document, folder: Path) -> None:
    """Makes relative names of meshes whole URIs: a text has no folder of its own."""
    for element in document.getElementsByTagName("*"):
        name = element.getAttribute("filename")
        if name and "://" not in name:
            element.setAttribute("filename", (folder / name).absolute().as_uri())


def parse_model(
    plant: MultibodyPlant, where: str, path: Path, name: str, text: str | None = None
) -> ModelInstanceIndex:
    """Adds the file's model, or that of `text` in its place, as model instance `name`.

    Raises InvalidInputError, with the place `where`, if it does not parse.
    """
    parser = Parser(plant, model_name_prefix="")
    parser.SetAutoRenaming(True)
    packages = parser.package_map()
    for known in packages.GetPackageNames():
        packages.Remove(known)  # one of Drake's own would be fetched from the network
    packages.AddPackageXml(str(package_xml()))
    own = package_of(path)
    if own is not None and not packages.Contains(own[0]):
        packages.Add(own[0], str(own[1]))
    try:
        added = parser.AddModels(str(path)) if text is None else parser.AddModelsFromString(text, "urdf")
        (instance,) = added
    except (RuntimeError, ValueError) as error:
        raise _unparsable(where, path, error) from error
    plant.RenameModelInstance(instance, name)
    return instance


def require_collision_geometry(balls: Sequence[np.ndarray], where: str, model: str) -> None:
    """Raises InvalidInputError for a model that nothing could touch: it would have no radius."""
    if not any(map(len, balls)):
        what = f"{resolve(model).name} has no collision geometry"
        raise InvalidInputError(
            [Mistake(where, what, "give its links <collision> elements: radii are measured of them")]
        )


def _unparsable(where: str, path: Path, error: Exception) -> InvalidInputError:
    reason = str(error).strip().splitlines()[-1]
    for its_name in ("<literal-string>.urdf", f"/{path}", str(path)):  # what Drake calls a text, and a file
        reason = reason.replace(its_name, path.name)
    return InvalidInputError([Mistake(where, f"{path.name} does not parse: {reason}", "mend the file")])
