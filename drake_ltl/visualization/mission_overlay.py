"""LeafSystem that shows the bounding spheres and names of a mission's members in Meshcat."""

from __future__ import annotations

import numpy as np
from pydrake.common import MemoryFile
from pydrake.geometry import InMemoryMesh, Mesh, Meshcat, Rgba, Sphere
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import Context, EventStatus, InputPort, LeafSystem

from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.visualization.palette import Colour, member_colours
from drake_ltl.visualization.spheres import shown_agents, shown_objects, shown_teams
from drake_ltl.visualization.text_plate import text_gltf

PATH = "/mission"
"""Root of all that is drawn besides the bodies, in Meshcat's tree."""
CLOCK_PATH = f"{PATH}/clock"
"""Nothing is there; its x is the time of the scene, by which live pages tell how far they are."""
PUBLISH_PERIOD = 1 / 16
"""[s]; recordings have as many frames, and the page interpolates between them: more make it larger, not smoother."""
AGENT_OPACITY, OBJECT_OPACITY, TEAM_OPACITY = 0.20, 0.22, 0.14


class MissionOverlay(LeafSystem):
    """Publishes spheres about c_i (r_i), about Oo (r_j^O) and, while an object is carried, about Oo (r_{T,j}).

    .. pydrake_system::

        name: MissionOverlay
        input_ports:
        - status
        - state_<agent>
        - state_<object>

    `status` is that of PlanSupervisor; `state_<agent>` (2 n,), `state_<object>` (13,). Objects are set once, in the
    constructor; poses and visibility are published every PUBLISH_PERIOD with their time, so that they are recorded.
    """

    def __init__(self, models: MeasuredModels, meshcat: Meshcat, *, name_height: float, name_tilt: float = 0.0):
        """Names are written on plates.

        Args:
            name_height: of the agents' plates [m]; the objects' are smaller.
            name_tilt: by which they lean back [rad]: the elevation of the camera for which they are made.
        """
        super().__init__()
        self.set_name("mission_overlay")
        self._meshcat = meshcat
        self._agents, self._geometry = models.agents, models.geometry
        self._objects = tuple(models.objects)
        self._name_height, self._name_tilt = name_height, name_tilt
        self._status = self.DeclareVectorInputPort("status", 2 + 2 * len(models.agents))
        self._state = {
            name: self.DeclareVectorInputPort(f"state_{name}", 2 * model.n) for name, model in models.agents.items()
        }
        self._state |= {name: self.DeclareVectorInputPort(f"state_{name}", 13) for name in self._objects}
        self._set_objects()
        self.DeclareInitializationPublishEvent(self._publish)
        self.DeclarePeriodicPublishEvent(PUBLISH_PERIOD, 0.0, self._publish)
        self.DeclareForcedPublishEvent(self._publish)

    def get_status_input_port(self) -> InputPort:
        return self._status

    def get_state_input_port(self, name: str) -> InputPort:
        """Of an agent (2 n,) or an object (13,)."""
        return self._state[name]

    def _set_objects(self) -> None:
        colours = member_colours(tuple(self._agents), self._objects)
        radii = {**self._geometry.agent_radius, **self._geometry.object_radius}
        for name in self._agents:
            self._set_ball(sphere_path(name), radii[name], colours[name], AGENT_OPACITY)
            self._set_name(name, np.array([0.0, 0.0, radii[name]]), self._name_height, colours[name])
        for name in self._objects:
            self._set_ball(sphere_path(name), radii[name], colours[name], OBJECT_OPACITY)
            self._set_ball(team_path(name), self._geometry.team_radius[name], colours[name], TEAM_OPACITY)
            self._set_name(name, np.array([0.0, -radii[name], 0.0]), 0.75 * self._name_height, colours[name])

    def _set_name(self, name: str, p_MN: np.ndarray, height: float, colour: Colour) -> None:
        """An agent's name stands over it, an object's before it: those of a team are then apart."""
        outwards = 0.6 * height * p_MN / np.linalg.norm(p_MN)
        off_the_floor = np.array([0.0, 0.0, 0.3 * height])
        X_MN = RigidTransform(RotationMatrix.MakeXRotation(-self._name_tilt), p_MN + outwards + off_the_floor)
        set_text(self._meshcat, name_path(name), name, height, colour)
        self._meshcat.SetTransform(name_path(name), X_MN)

    def _set_ball(self, path: str, radius: float, colour: Colour, opacity: float) -> None:
        self._meshcat.SetObject(path, Sphere(radius), Rgba(*colour, opacity))
        let_through(self._meshcat, path)

    def _publish(self, context: Context) -> EventStatus:
        time = context.get_time()
        status = self._status.Eval(context)
        modes = [int(mode) for mode in status[2 : 2 + len(self._agents)]]
        centres = {
            name: model.centre(self._state[name].Eval(context)[: model.n]) for name, model in self._agents.items()
        }
        origins = {name: self._state[name].Eval(context)[4:7] for name in self._objects}
        for name, p_WM in {**centres, **origins}.items():
            self._meshcat.SetTransform(member_path(name), RigidTransform(p_WM), time)
        self._meshcat.SetTransform(CLOCK_PATH, RigidTransform(np.array([time, 0.0, 0.0])))
        num_objects = len(self._objects)
        visible = dict(zip(map(sphere_path, self._agents), shown_agents(modes), strict=True))
        visible |= zip(map(sphere_path, self._objects), shown_objects(modes, num_objects), strict=True)
        visible |= zip(map(team_path, self._objects), shown_teams(modes, num_objects), strict=True)
        for path, shown in visible.items():
            self._meshcat.SetProperty(path, "visible", shown, time)
        return EventStatus.Succeeded()


def member_path(name: str) -> str:
    """What moves with a member: a frame at c_i or Oo with the world's axes."""
    return f"{PATH}/members/{name}"


def sphere_path(name: str) -> str:
    """A member's own sphere."""
    return f"{member_path(name)}/sphere"


def team_path(obj: str) -> str:
    """The sphere of an object with the team that carries it."""
    return f"{member_path(obj)}/team"


def name_path(name: str) -> str:
    """A member's name."""
    return f"{member_path(name)}/name"


def set_text(meshcat: Meshcat, path: str, text: str, height: float, colour: Colour) -> None:
    """A plate with text at `path`: upright, in its frame's xz plane, read from -y."""
    mesh = InMemoryMesh(mesh_file=MemoryFile(text_gltf(text, height, colour), ".gltf", text))
    meshcat.SetObject(path, Mesh(mesh_data=mesh))


def let_through(meshcat: Meshcat, path: str) -> None:
    """Keeps a translucent body from hiding translucent ones behind and inside it, and from veiling names."""
    meshcat.SetProperty(f"{path}/<object>", "material.depthWrite", False)
    meshcat.SetProperty(f"{path}/<object>", "renderOrder", -1.0)
