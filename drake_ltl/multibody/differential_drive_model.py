"""One differential drive alone: its wheels, its reduced inertia and its tyres."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import RevoluteJoint
from pydrake.systems.framework import DiagramBuilder

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.multibody.collision_balls import body_balls, farthest, moved
from drake_ltl.multibody.parsing import CENTRE_FRAME, parse_model
from drake_ltl.scenario.model_files import WHEELS, resolve

DIFFERENTIAL_DRIVE = "package://drake_ltl_models/bases/differential_drive.urdf"
"""The one that is shipped."""
TOLERANCE = 1e-3
"""Of the symmetry that the control law counts on [m]."""


class DifferentialDriveModel:
    """What is constant of a differential drive.

    Its URDF has one free base, whose frame lies on the floor below the middle of the axle, x forward, z up; two wheels
    on revolute joints `left` and `right` with axis y and an actuator each; casters without friction, as the model
    wants; a frame `bounding_centre` above the base's origin; and its centre of mass there, too.
    """

    def __init__(self, name: str, model: str = DIFFERENTIAL_DRIVE):
        """Raises InvalidInputError with one mistake for each point in which the model differs."""
        builder = DiagramBuilder()
        plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
        self.name, self.model = name, model
        self._instance = parse_model(plant, f"{name}.model", _file(name, model), name)
        plant.Finalize()
        self._diagram, self._plant = builder.Build(), plant  # the diagram owns the plant
        self._context = plant.CreateDefaultContext()
        self._require_parts()
        left, right = (plant.GetJointByName(wheel) for wheel in WHEELS)
        base = left.parent_body()
        for body in plant.GetFloatingBaseBodies():
            plant.SetFreeBodyPose(self._context, plant.get_body(body), RigidTransform())
        X_WL, X_WR = (joint.frame_on_parent().CalcPoseInWorld(self._context) for joint in (left, right))
        self._starts = (base.floating_velocities_start_in_v(), left.velocity_start(), right.velocity_start())
        self.wheel_radius: float = float(X_WL.translation()[2])
        """[m]"""
        self.half_track: float = float(X_WL.translation()[1])
        """Half the distance of the wheels [m]."""
        actuators = [plant.get_joint_actuator(index) for index in plant.GetJointActuatorIndices()]
        self.effort: float = min(actuator.effort_limit() for actuator in actuators)
        """Largest torque of a wheel [N m]; Drake's plant applies no more."""
        bodies = [plant.get_body(index) for index in plant.GetBodyIndices(self._instance)]
        balls = np.concatenate(
            [
                moved(body.EvalPoseInWorld(self._context), body_balls(plant, scene_graph.model_inspector(), body))
                for body in bodies
                if len(plant.GetCollisionGeometriesForBody(body))
            ]
        )
        centre = plant.GetFrameByName(CENTRE_FRAME).CalcPoseInWorld(self._context).translation()
        self.height: float = float(centre[2])
        """Of the bounding sphere's centre above the floor [m]."""
        self.radius: float = farthest(balls, centre)
        """Of the smallest sphere about `bounding_centre` that covers it [m]."""
        self._require_symmetry(X_WL, X_WR, left, right, centre, float((balls[:, 2] - balls[:, 3]).min()))
        self.mass, self.inertia = self._reduced_inertia()
        self.weight: float = -plant.CalcGravityGeneralizedForces(self._context)[self._starts[0] + 5]
        """[N]"""
        tyres = [g for wheel in (left, right) for g in plant.GetCollisionGeometriesForBody(wheel.child_body())]
        materials = map(scene_graph.model_inspector().GetProximityProperties, tyres)
        self.tyre_friction: float = min(
            m.GetProperty("material", "coulomb_friction").static_friction() for m in materials
        )
        """Static coefficient of the wheels."""

    def _reduced_inertia(self) -> tuple[float, float]:
        """m and I of (U1): S^T M S for the rolling motions v and omega, wheels and their motors' rotors included."""
        start, left, right = self._starts
        S = np.zeros((self._plant.num_velocities(), 2))
        r, b = self.wheel_radius, self.half_track
        S[start + 3, 0], S[left, 0], S[right, 0] = 1.0, 1.0 / r, 1.0 / r
        S[start + 2, 1], S[left, 1], S[right, 1] = 1.0, -b / r, b / r
        M = self._plant.CalcMassMatrix(self._context)
        reduced = S.T @ M @ S
        return float(reduced[0, 0]), float(reduced[1, 1])

    def _require_parts(self) -> None:
        plant, found = self._plant, []
        for wheel in WHEELS:
            if not (plant.HasJointNamed(wheel) and isinstance(plant.GetJointByName(wheel), RevoluteJoint)):
                found.append((f"has no wheel on a revolute joint {wheel!r}", f"call the wheels' joints {WHEELS}"))
        if not found and {plant.get_joint_actuator(i).joint().name() for i in plant.GetJointActuatorIndices()} != set(
            WHEELS
        ):
            found.append(("has actuators for other joints than its wheels", "give each wheel one, and nothing else"))
        if plant.num_velocities() != 8:
            what = f"has {plant.num_velocities()} degrees of freedom"
            found.append((what, "a free base has 6, its wheels 2: fix all other joints"))
        if not plant.HasFrameNamed(CENTRE_FRAME):
            found.append((f"has no frame {CENTRE_FRAME!r}", "add it above the middle of the axle"))
        self._refuse(found)
        wheels = [plant.GetJointByName(wheel).child_body() for wheel in WHEELS]
        found += [
            (f"has a wheel {wheel.name()!r} without {what}", remedy)
            for wheel in wheels
            for what, remedy, has in (
                ("collision geometry", "give it a tyre", bool(plant.GetCollisionGeometriesForBody(wheel))),
                ("mass", "give it an <inertial>", wheel.default_mass() > 0.0),
            )
            if not has
        ]
        self._refuse(found)

    def _require_symmetry(self, X_WL, X_WR, left, right, centre, lowest: float) -> None:
        """The law counts on all of it; each is one line."""
        found = []
        p_L, p_R = X_WL.translation(), X_WR.translation()
        axes = [X.rotation() @ joint.revolute_axis() for X, joint in ((X_WL, left), (X_WR, right))]
        if not np.allclose(axes, [0.0, 1.0, 0.0], atol=1e-6):
            found.append(("has wheels whose axes are not y of the base", "both turn forwards about +y"))
        if not (p_L[1] > 0.0 and np.allclose(p_L * [1, -1, 1], p_R, atol=TOLERANCE) and abs(p_L[0]) < TOLERANCE):
            found.append((f"has its wheels at {p_L} and {p_R}", "put them at (0, b, r) and (0, -b, r) of the base"))
        if abs(lowest) > TOLERANCE:
            found.append((f"reaches down to z = {lowest:.4g} m", "put the base's origin on the floor"))
        p_com = self._plant.CalcCenterOfMassPositionInWorld(self._context)
        if np.abs(p_com[:2]).max() > TOLERANCE:
            found.append((f"has its centre of mass at {p_com}", "put it above the middle of the axle"))
        if np.abs(centre[:2]).max() > TOLERANCE:
            found.append((f"has {CENTRE_FRAME!r} at {centre}", "put it above the middle of the axle"))
        self._refuse(found)

    def _refuse(self, found: list[tuple[str, str]]) -> None:
        if found:
            file = _file(self.name, self.model).name
            raise InvalidInputError([Mistake(f"{self.name}.model", f"{file} {what}", do) for what, do in found])


def _file(name: str, model: str) -> Path:
    """Raises InvalidInputError if there is none."""
    try:
        path = resolve(model)
        if path.is_file():
            return path
        what = f"{model!r} is no file"
    except ValueError as error:
        what = str(error)
    raise InvalidInputError([Mistake(f"{name}.model", what, f"write the path of a URDF, or {DIFFERENTIAL_DRIVE}")])
