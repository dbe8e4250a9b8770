"""The problem as immutable data: workspace, regions, agents, objects and what each must do.

All lengths are in m, angles in rad; positions are in the world frame W, whose z axis points up from the
floor.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

from drake_ltl.shown import Shown

if TYPE_CHECKING:
    from pathlib import Path

    from rich.console import RenderableType

from drake_ltl.scenario.faults import Fault


@dataclass(frozen=True)
class Region:
    """A ball pi_k of the workspace."""

    name: str
    centre: tuple[float, float, float]
    radius: float


@dataclass(frozen=True)
class Agent:
    """A robot i with its power zeta_i and its formula phi_i over what it experiences itself."""

    name: str
    model: str
    """URI of the URDF (`package://drake_ltl_models/...`) or a path, already absolute or package-relative."""
    position: tuple[float, float]
    heading: float
    power: float
    spec: str = "1"
    joints: tuple[float, ...] | None = None
    """Arm joint angles at the start; None lets the start posture be chosen."""
    radius: float | None = None
    """r_i; None means that it is measured from the model."""
    has_arm: bool = True
    """False of a differential drive: it travels, and grasps nothing."""
    headings: Mapping[str, float] = field(default_factory=dict)
    """Of a differential drive: region -> the heading with which it arrives there; elsewhere it is `heading`."""


@dataclass(frozen=True)
class TransportObject:
    """An object j with the power Lambda_j that carrying it needs, and its formula phi_j^O."""

    name: str
    model: str
    position: tuple[float, float]
    power_needed: float
    spec: str = "1"
    radius: float | None = None
    """r_j^O; None means that it is measured from the model."""
    team_radius: float | None = None
    """r_{T,j}; None means that it is computed from the models."""
    orientation: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw at the start: R_WO = Rz(yaw) Ry(pitch) Rx(roll). Roll and pitch, how it lies, stay so."""
    headings: Mapping[str, float] = field(default_factory=dict)
    """region -> the heading with which a transport sets it down there; elsewhere it keeps the one that it has."""

    @property
    def heading(self) -> float:
        """Its yaw at the start."""
        return self.orientation[2]

    @property
    def is_turned(self) -> bool:
        """Whether some transport may have to turn it."""
        return any(heading != self.heading for heading in self.headings.values())


@dataclass(frozen=True)
class PublishedFits:
    """A region's content fits iff a weighted count of its bodies does not exceed a capacity."""

    agent: float
    grasping: float
    object: float
    capacity: float


@dataclass(frozen=True)
class ControllerSettings:
    """Gains of the control laws (10a), (10b), the hold and the reach controllers."""

    kappa: float | None = None
    """Exponent of the navigation function; None lets it grow with the number of relations, as it must."""
    lambda_: float = 0.0
    """Weight of the relation verification functions (key `lambda` in a file)."""
    h: float = 1.0
    """Root of the complement's product in the relation verification functions."""
    force: float = 40.0
    """k, far-field force of the navigation potential [N]."""
    delta: float = 0.5
    """Distance within which the potential turns quadratic [m]; k / delta is the stiffness at the goal."""
    shaping: Any = "pseudo_huber"
    """psi: pseudo_huber, logarithmic or paper; from Python also a `drake_ltl.navigation.Shaping` of one's own."""
    base_damping: float = 18.0
    """K_z of the base's joints [N s/m]."""
    arm_damping: float = 1.8
    """K_z of an arm's joint with an inertia of 0.15 kg m^2 [N m s/rad]; it grows with the root of the inertia."""
    team_damping: float = 24.0
    """Damping of the carried object's velocity [N s/m]."""
    team_rotation_damping: float = 4.0
    """Damping of the carried object's angular velocity [N m s/rad]."""
    speed_limit: float = 2.0
    """Damping grows with the square of the speed beyond this [m/s]."""
    period: float = 0.02
    """The supervisor looks for what has arrived this often [s]."""


@dataclass(frozen=True)
class Tolerances:
    """When a goal counts as reached and a grasp as made."""

    position: float = 0.03
    """Travel and transport end within this distance of the goal [m]."""
    speed: float = 0.03
    """... and below this speed [m/s]."""
    joint: float = 0.03
    """... with arm joints this close [rad]."""
    angle: float = 0.03
    """... and what is carried this close to its heading [rad]."""
    weld_position: float = 1e-3
    """Largest gap at which a weld is made [m]."""
    weld_angle: float = 1.7453292519943296e-3
    """Largest misalignment at which a weld is made [rad] (0.1 degree)."""


@dataclass(frozen=True)
class SimulationSettings:
    """How a mission is run."""

    time_step: float = 0.005
    """Of the discrete plant [s]."""
    suffix_rounds: int = 1
    step_time_limit: float = 300.0
    """A plan step that takes longer stops the run with a verdict [s]."""


@dataclass(frozen=True)
class Scenario(Shown):
    """A whole problem, validated. See `drake_ltl.scenario.load`."""

    name: str
    workspace_radius: float
    regions: tuple[Region, ...]
    agents: tuple[Agent, ...]
    objects: tuple[TransportObject, ...]
    spec: str = "1"
    """Global formula over `member.proposition`."""
    services: Mapping[str, Mapping[str, tuple[str, ...]]] = field(default_factory=dict)
    """L_i and L_j^O as member -> region -> services; a region not named offers its own name."""
    cost: str = "squared_distance"
    fits: PublishedFits | None = None
    """None means geometric."""
    seed: int = 0
    controller: ControllerSettings = ControllerSettings()
    tolerances: Tolerances = Tolerances()
    simulation: SimulationSettings = SimulationSettings()
    team_radius: float | None = None
    """What holds for every object that says nothing of its own; the objects carry it too."""
    faults: tuple[Fault, ...] = ()
    """What goes wrong in the simulation."""
    source: str = ""
    """The text the scenario was read from; a recording carries it."""

    @staticmethod
    def load(file: Path | str) -> Scenario:
        """The same as `drake_ltl.load`."""
        from drake_ltl.api import load

        return load(file)

    def __repr__(self) -> str:
        counts = f"{len(self.agents)} agents, {len(self.objects)} objects, {len(self.regions)} regions"
        return f"Scenario({self.name!r}, {counts})"

    def __rich__(self) -> RenderableType:
        from drake_ltl.scenario.overview import scenario_table

        return scenario_table(self)

    def _repr_svg_(self) -> str:
        """The map."""
        from drake_ltl.visualization.notebook import map_svg

        return map_svg(self)

    def _repr_html_(self) -> str:
        """Map and table; the table alone where nothing can be drawn yet."""
        from drake_ltl.errors import DrakeLtlError
        from drake_ltl.visualization.notebook import map_html

        try:
            return f"{map_html(self)}{super()._repr_html_()}"
        except DrakeLtlError as error:
            return f"<p>no map: {error}</p>{super()._repr_html_()}"

    @cached_property
    def region_names(self) -> tuple[str, ...]:
        return tuple(region.name for region in self.regions)

    @cached_property
    def agent_names(self) -> tuple[str, ...]:
        return tuple(agent.name for agent in self.agents)

    @cached_property
    def object_names(self) -> tuple[str, ...]:
        return tuple(obj.name for obj in self.objects)

    def region(self, name: str) -> Region:
        """The region called `name`; KeyError if there is none."""
        return self._regions[name]

    @cached_property
    def _regions(self) -> dict[str, Region]:
        return {region.name: region for region in self.regions}
