"""V = k psi(w) + kinetic energy + h of redundant carriers + h_O of loads, formed from the recorded motion: another hand
than the one that steers.

w = gamma / (G / G_goal)^(1/kappa), where gamma adds the squared errors of all movers and G is the product of the
paper's functions beta, one for every pair of spheres that must stay apart (or of its relation verification functions);
psi is the scenario's shaping. Who moves where is taken from the recording's intervals; everything else stands where it
stood when the interval began.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import combinations, product
from typing import TYPE_CHECKING

import numpy as np

from drake_ltl.execution.recording import IntervalRecord, Recording
from drake_ltl.scenario.model import ControllerSettings, Scenario
from drake_ltl.verification.poses import rotations

if TYPE_CHECKING:
    from drake_ltl.navigation import RelationSets

LEAST_KAPPA, KAPPA_PER_FACTOR = 12.0, 1.25
"""kappa where the scenario leaves it open."""
MOST_POWER = 0.8
"""Of w in the pseudo-Huber shaping."""
LIFT, DESCENT = 0.05, 0.2
"""How high loads are carried, and at which distance from their goals they have come down by half [m]."""
HEIGHT_STIFFNESS, TILT_STIFFNESS = 1000.0, 60.0
"""What holds them there, and level [N/m, N m/rad]."""
TINY = 1e-300
TOUCHING = 1e300
"""V where spheres touch [J]: in place of infinity, so that differences stay numbers."""


@dataclass(frozen=True)
class Interval:
    """One navigation function's time, with what the models say of its goals."""

    record: IntervalRecord
    goals: Mapping[str, np.ndarray]
    """Traveller -> c_z at its goal (3,) [m]."""
    ends: Mapping[str, tuple[np.ndarray, np.ndarray]]
    """Agent that reaches -> c_i at both ends of its way [m]."""

    def samples(self, recording: Recording) -> np.ndarray:
        """Indices of its samples."""
        return np.flatnonzero((recording.step == self.record.step) & (recording.phase == self.record.phase))


@dataclass(frozen=True)
class Motion:
    """What moved, and how."""

    recording: Recording
    scenario: Scenario
    centre: Mapping[str, np.ndarray]
    """agent -> c_i (T, 3) [m]."""
    energy: Mapping[str, np.ndarray]
    """member -> kinetic energy (T,) [J]."""
    gamma_weights: Mapping[str, np.ndarray]
    """agent with an arm -> weight of each joint in gamma (n_i,)."""
    orientation_goals: Mapping[tuple[int, str], np.ndarray] = field(default_factory=dict)
    """(step, object) -> quaternion (4,) that it should have at the end of the step."""
    posture_energy: Mapping[str, Callable[[int, np.ndarray], np.ndarray]] = field(default_factory=dict)
    """redundant agent -> its h (n,) [J] at samples (n,), with the posture of one sample for its reference."""


@dataclass(frozen=True)
class _Sphere:
    radius: float
    way: np.ndarray
    """(n, 3), or (1, 3) of what stands."""
    goal: np.ndarray
    """(3,)"""
    regions: frozenset[str] = frozenset()
    """Where a mover may be; empty for what stands."""


def lyapunov(motion: Motion, interval: Interval, rows: np.ndarray) -> np.ndarray:
    """V (n,) [J] at the samples `rows` (n,) of an interval; TOUCHING where spheres touch, there or at the goal."""
    scenario, record = motion.scenario, interval.record
    settings = scenario.controller
    movers = [*_travellers(motion, interval, rows), *_teams(motion, interval, rows)]
    others = [*_standing(motion, interval, int(rows[0]))]
    apart = [*_apart(motion, movers, others)]
    inside = [*_inside(motion, movers)]
    relations = _realisable(motion, movers, others) if settings.lambda_ else None
    gathering = "gathering" not in motion.recording.lacks  # else kappa and psi are those of older versions
    factors = len(inside) + (len(relations.sets) if relations and gathering else len(apart))
    kappa = settings.kappa or max(LEAST_KAPPA, KAPPA_PER_FACTOR * factors)
    log_G = _log_obstacle(settings, relations)
    betas = [np.stack(columns, axis=-1) for columns in zip(*apart, *inside, strict=True)]
    touching = (betas[0] <= 0.0).any(axis=-1) | (betas[1] <= 0.0).any()
    with np.errstate(divide="ignore", invalid="ignore"):  # logarithms of betas <= 0
        here, at_goal = map(log_G, betas)
        w = np.where(touching, 0.0, _gamma(motion, record, rows) * np.exp((at_goal - here) / kappa))
    is_closer = gathering and bool(at_goal < here.flat[0])  # at the goals than at the start
    psi = _psi(settings, kappa, w, len(movers) if is_closer else 1)
    energy = _energy(motion, record, rows) + _posture_energy(motion, record, rows) + _load_energy(motion, record, rows)
    return np.where(touching, TOUCHING, settings.force * psi + energy)


def _psi(settings: ControllerSettings, kappa: float, w: np.ndarray, n_movers: int) -> np.ndarray:
    """psi(w) of the scenario's shaping; one of the user's own is taken at its word."""
    delta = settings.delta
    if settings.shaping == "pseudo_huber":
        straight = max(2.0 - n_movers * (n_movers - 1) / kappa, 1.0 / MOST_POWER)
        return delta / 2.0 * straight * np.expm1(np.log1p(w / delta**2) / straight)
    if settings.shaping == "logarithmic":
        return 0.5 * delta * np.log1p(w / delta**2)
    if settings.shaping == "paper":  # w / (1 + w^kappa)^(1/kappa), with powers of what is at most 1 alone
        low, high = np.minimum(w, 1.0), np.maximum(w, 1.0)
        return low * (1.0 + low**kappa) ** (-1.0 / kappa) * ((1.0 + high**-kappa) / 2.0) ** (-1.0 / kappa)
    with np.errstate(divide="ignore"):
        return settings.shaping.value(np.log(w))


def _log_obstacle(settings: ControllerSettings, relations: RelationSets | None) -> Callable[[np.ndarray], np.ndarray]:
    """log G of betas (..., n), those of pairs first; `relations` for lambda > 0."""
    if relations is None:
        return lambda betas: np.log(betas).sum(axis=-1)
    levels = [
        np.array([np.isin(range(relations.n_apart), chosen) for chosen in relations.of_level(level)], dtype=float)
        for level in range(1, relations.levels + 1)
    ]

    def log_G(betas: np.ndarray) -> np.ndarray:
        pairs, inside = betas[..., : relations.n_apart], betas[..., relations.n_apart :]
        total = np.log(inside).sum(axis=-1)
        for members in levels:
            log_b = np.log(pairs @ members.T)
            log_B = log_b.sum(axis=-1, keepdims=True) - log_b
            share = np.exp(log_b - np.logaddexp(log_b, log_B / settings.h))  # b / (b + B^(1/h))
            total = total + np.log(np.exp(log_b) + settings.lambda_ * share).sum(axis=-1)
        return total

    return log_G


def _realisable(motion: Motion, movers: list[_Sphere], others: list[_Sphere]) -> RelationSets:
    """Sets of the pairs of `_pairs` that can touch at once."""
    from drake_ltl.navigation import Apart, Inside, Relations, realisable_sets  # for lambda > 0 alone

    pairs = list(_pairs(motion, movers, others))
    bodies = list({id(body): body for body in (*movers, *(body for pair in pairs for body in pair))}.values())
    number = {id(body): index for index, body in enumerate(bodies)}
    apart = tuple(Apart(number[id(a)], number[id(b)], a.radius + b.radius) for a, b in pairs)
    inside = tuple(Inside(number[id(a)], tuple(centre), radius) for a, centre, radius in _balls(motion, movers))
    fixed = tuple((number[id(body)], tuple(map(float, body.goal))) for body in bodies[len(movers) :])
    return realisable_sets(Relations(len(bodies), apart, inside), fixed)


def _gamma(motion: Motion, record: IntervalRecord, rows: np.ndarray) -> np.ndarray:
    """(n,) [m^2]: errors of all movers, and 2 (1 - cos) of the angle to its goal of what is carried."""
    recording, gamma = motion.recording, np.zeros(len(rows))
    for name, goal in record.travels.items():
        if name in motion.gamma_weights:
            gamma += (recording.q[name][rows] - goal) ** 2 @ motion.gamma_weights[name]
        else:
            gamma += _dipole(recording.q[name][rows], goal)
    for name, goal in record.transports.items():
        pose = recording.pose[name][rows]
        aligned = pose[:, :4] @ motion.orientation_goals[record.step, name]  # cosine of half the angle
        turned = 1.0 - aligned**2 / np.einsum("ij,ij->i", pose[:, :4], pose[:, :4])
        gamma += ((pose[:, 4:] - goal) ** 2).sum(axis=1) + 4.0 * turned
    return gamma


def _dipole(q: np.ndarray, goal: tuple[float, ...]) -> np.ndarray:
    """gamma (n,) [m^2] of a differential drive at q (n, 8): its error along the heading of its goal counts a quarter
    near by, and all within metres."""
    x, y, heading = goal[:3]
    away = (q[:, 0] - x) + 1j * (q[:, 1] - y)
    along = (away * np.exp(-1j * heading)).real
    return np.abs(away) ** 2 - 0.75 * np.log1p(along**2)


def _energy(motion: Motion, record: IntervalRecord, rows: np.ndarray) -> np.ndarray:
    moving = [*record.travels, *record.transports, *_carriers(motion, record)]
    return sum((motion.energy[name][rows] for name in moving), np.zeros(len(rows)))


def _posture_energy(motion: Motion, record: IntervalRecord, rows: np.ndarray) -> np.ndarray:
    """h of the redundant agents that carry; their springs rest where the step began."""
    recording = motion.recording
    begin = int(rows[0]) if "lift" in recording.lacks else int(np.argmax(recording.step == record.step))
    springs = [motion.posture_energy[name] for name in _carriers(motion, record) if name in motion.posture_energy]
    return sum((energy(begin, rows) for energy in springs), np.zeros(len(rows)))


def _load_energy(motion: Motion, record: IntervalRecord, rows: np.ndarray) -> np.ndarray:
    """h_O of what is carried: off the height at which it should be at its distance from the goal, and tilted."""
    h = np.zeros(len(rows))
    if "lift" in motion.recording.lacks:
        return h
    for name, goal in record.transports.items():
        pose = motion.recording.pose[name][rows]
        away = ((pose[:, 4:6] - goal[:2]) ** 2).sum(axis=1)
        height = goal[2] + LIFT / (1.0 + DESCENT**2 / np.maximum(away, TINY))
        up = rotations(pose) * rotations(motion.orientation_goals[record.step, name][None]).inv()
        h += HEIGHT_STIFFNESS / 2.0 * (pose[:, 6] - height) ** 2
        h += TILT_STIFFNESS * (1.0 - up.as_matrix()[:, 2, 2])
    return h


def _carriers(motion: Motion, record: IntervalRecord) -> list[str]:
    teams = {action["object"]: action["agents"] for action in _actions(motion, record) if action["kind"] == "transport"}
    return [agent for name in record.transports for agent in teams[name]]


def _actions(motion: Motion, record: IntervalRecord) -> tuple[dict, ...]:
    return motion.recording.steps[record.step].actions


def _travellers(motion: Motion, interval: Interval, rows: np.ndarray) -> Iterator[_Sphere]:
    actions = _actions(motion, interval.record)
    for name, goal in interval.goals.items():
        (action,) = (a for a in actions if name in a["agents"])
        regions = frozenset((action["from"], action["to"]))
        yield _Sphere(motion.recording.agent_radius[name], motion.centre[name][rows], goal, regions)


def _teams(motion: Motion, interval: Interval, rows: np.ndarray) -> Iterator[_Sphere]:
    actions = _actions(motion, interval.record)
    for name, goal in interval.record.transports.items():
        (action,) = (a for a in actions if a["object"] == name)
        regions = frozenset((action["from"], action["to"]))
        way = motion.recording.pose[name][rows, 4:]
        way[:, 2] = goal[2]  # of what is carried G sees x and y
        yield _Sphere(motion.recording.team_radius[name], way, np.array(goal), regions)


def _standing(motion: Motion, interval: Interval, begin: int) -> Iterator[_Sphere]:
    """What stands as it stood at the sample `begin`, those that reach at both ends of their way."""
    recording, record = motion.recording, interval.record
    in_teams = {
        agent
        for action in _actions(motion, record)
        if action["kind"] == "transport" and action["object"] in (*record.transports, *record.waiting)
        for agent in action["agents"]
    }
    for name in recording.agents:
        if name in interval.ends:
            start, goal = interval.ends[name]
            radius = float(np.hypot(recording.agent_radius[name], np.linalg.norm(goal - start) / 2))
            yield from (_Sphere(radius, end[None], end) for end in (start, goal))
        elif name not in record.travels and name not in in_teams:
            yield _still(recording.agent_radius[name], motion.centre[name][begin])
    for name in recording.objects:
        if name not in record.transports:
            radii = recording.team_radius if name in record.waiting else recording.object_radius
            yield _still(radii[name], recording.pose[name][begin, 4:])


def _still(radius: float, p: np.ndarray) -> _Sphere:
    return _Sphere(radius, p[None], p)


def _pairs(motion: Motion, movers: list[_Sphere], others: list[_Sphere]) -> Iterator[tuple[_Sphere, _Sphere]]:
    """All that must stay apart."""
    yield from combinations(movers, 2)
    yield from product(movers, others)
    for region in motion.scenario.regions:
        ball = _still(region.radius, np.array(region.centre, dtype=float))
        yield from ((mover, ball) for mover in movers if region.name not in mover.regions)


def _apart(motion: Motion, movers: list[_Sphere], others: list[_Sphere]) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """beta = |p_a - p_b|^2 - (r_a + r_b)^2 of each pair, on the way (n,) and at the goal ()."""
    for a, b in _pairs(motion, movers, others):
        least = (a.radius + b.radius) ** 2
        yield ((a.way - b.way) ** 2).sum(axis=1) - least, ((a.goal - b.goal) ** 2).sum() - least


def _balls(motion: Motion, movers: list[_Sphere]) -> Iterator[tuple[_Sphere, np.ndarray, float]]:
    """Where each mover's centre stays, and how near to it: in the workspace, and in the region it does not leave."""
    for mover in movers:
        yield mover, np.zeros(3), motion.scenario.workspace_radius - mover.radius
        if len(mover.regions) == 1:
            region = motion.scenario.region(next(iter(mover.regions)))
            yield mover, np.array(region.centre, dtype=float), region.radius - mover.radius


def _inside(motion: Motion, movers: list[_Sphere]) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """beta = (R - r)^2 - |p - centre|^2 of each mover in each of its balls, on the way (n,) and at the goal ()."""
    for mover, centre, radius in _balls(motion, movers):
        way, goal = mover.way - centre, mover.goal - centre
        yield radius**2 - (way**2).sum(axis=1), radius**2 - goal @ goal
