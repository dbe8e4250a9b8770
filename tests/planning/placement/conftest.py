"""The paper's second example with numbers by hand, plans made of states, and a plain checker of placed missions."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from types import SimpleNamespace

import pytest

from drake_ltl.planning.fits import Content
from drake_ltl.planning.geometry import Geometry, GraspOption
from drake_ltl.planning.mission import Layout, Mission
from drake_ltl.planning.plan import Action, Plan, State
from drake_ltl.scenario.model import Agent, Region, Scenario, TransportObject
from drake_ltl.scenario.starts import Starts, check_starts

CENTRES = {
    "pi1": (0.0, 0.0, 0.0),
    "pi2": (-14.0, -14.0, 0.0),
    "pi3": (20.0, -10.0, 0.0),
    "pi4": (-16.0, 15.0, 0.0),
}
AGENTS = {"a1": (0.5, 0.0), "a2": (18.5, -11.5), "a3": (-14.0, 15.0)}
OBJECTS = {"o1": (-14.0, -14.5), "o2": (-1.5, 0.2)}


def make_scenario(agents=AGENTS, objects=OBJECTS, centres=CENTRES, radius=3.5, workspace=30.0) -> Scenario:
    """A scenario with headings spread by a third of a turn and models that are never loaded."""
    return Scenario(
        name="by_hand",
        workspace_radius=workspace,
        regions=tuple(Region(name, centre, radius) for name, centre in centres.items()),
        agents=tuple(
            Agent(name, "", position, heading=2.0 * math.pi * k / 3.0, power=2.0)
            for k, (name, position) in enumerate(agents.items())
        ),
        objects=tuple(TransportObject(name, "", position, power_needed=4.0) for name, position in objects.items()),
    )


def make_geometry(scenario: Scenario) -> Geometry:
    """Radii and grasp options of the paper's agent and a crate."""
    postures, grasps = {}, {}
    for agent in scenario.agents:
        c, s = math.cos(agent.heading), math.sin(agent.heading)
        postures[agent.name] = {
            "plus": (0.784 * c, 0.784 * s, 0.36),
            "minus": (-0.784 * c, -0.784 * s, 0.36),
            "upright": (0.0, 0.0, 1.0),
        }
        for obj in scenario.objects:
            grasps[agent.name, obj.name] = tuple(
                GraspOption(
                    name,
                    (-sign * 1.85 * c, -sign * 1.85 * s, 0.11),
                    (-sign * 1.496 * c, -sign * 1.496 * s, 0.11),
                    name,
                )
                for name, sign in (("plus", 1.0), ("minus", -1.0))
            )
    return Geometry(
        agent_radius=dict.fromkeys(scenario.agent_names, 1.25),
        object_radius=dict.fromkeys(scenario.object_names, 0.5),
        object_height=dict.fromkeys(scenario.object_names, 0.25),
        team_radius=dict.fromkeys(scenario.object_names, 2.6),
        postures=postures,
        grasps=grasps,
    )


def actions_between(scenario: Scenario, before: State, after: State) -> tuple[Action, ...]:
    """The actions of Def. 5 that lead from one state to the next."""
    found = []
    for j, name in enumerate(scenario.object_names):
        if before.objects[j] != after.objects[j]:
            team = tuple(a for a, held in zip(scenario.agent_names, before.grasps, strict=True) if held == name)
            found.append(Action("transport", team, before.objects[j], after.objects[j], name))
    for i, name in enumerate(scenario.agent_names):
        start, goal = before.agents[i], after.agents[i]
        was, held = before.grasps[i], after.grasps[i]
        if was is None and held is not None:
            found.append(Action("grasp", (name,), start, goal, held))
        elif was is not None and held is None:
            found.append(Action("release", (name,), start, goal, was))
        elif was is None and start != goal:
            found.append(Action("travel", (name,), start, goal))
    return tuple(found)


def make_plan(scenario: Scenario, states: Sequence[State], loop: int) -> Plan:
    """The lasso through `states` that goes on at `loop` after the last."""
    following = [*states[1:], states[loop]]
    moves = tuple(actions_between(scenario, a, b) for a, b in zip(states, following, strict=True))
    return Plan(tuple(states[:loop]), tuple(states[loop:]), moves, 0.0, 0.0, 0.0, "feasible")


def _spheres(layout: Layout, scenario: Scenario, geometry: Geometry):
    agents = {a: (layout.agents[a].p_WC, geometry.agent_radius[a]) for a in scenario.agent_names}
    objects = {o: (layout.objects[o], geometry.object_radius[o]) for o in scenario.object_names}
    return agents, objects


def violations(mission: Mission, scenario: Scenario, geometry: Geometry, starts: Starts, margin=0.05) -> list[str]:
    """Every rule of an executable mission, checked with distances alone; empty if all hold."""
    found: list[str] = []
    regions = {r.name: r for r in scenario.regions}
    plan = mission.plan
    order = list(range(len(plan.states)))
    order += order[plan.loop :] * 3
    given = {a: s.p_WC for a, s in starts.agents.items()} | {o: s.p_WO for o, s in starts.objects.items()}

    def apart(name_a, a, name_b, b, where, needed=margin):
        (p, r), (q, s) = a, b
        if given.get(name_a) == p and given.get(name_b) == q:
            needed = 0.0
        if math.dist(p, q) - r - s < needed - 1e-9:
            found.append(f"{where}: {name_a} - {name_b}: {math.dist(p, q) - r - s:.3f}")

    def inside(name, ball, region, where):
        if math.dist(ball[0], regions[region].centre) + ball[1] > regions[region].radius + 1e-9:
            found.append(f"{where}: {name} not inside {region}")

    def holder_of(layout, agent, obj):
        return layout.agents[agent].grasp is not None and layout.agents[agent].grasp[0] == obj

    def option(layout, agent):
        obj, name = layout.agents[agent].grasp
        return next(o for o in geometry.grasps[agent, obj] if o.name == name)

    headings = {obj.name: obj.heading for obj in scenario.objects}
    if mission.steps[0].before != Layout(
        mission.steps[0].before.agents, {o: s.p_WO for o, s in starts.objects.items()}, headings
    ):
        found.append("objects do not begin at their starts")
    for a, s in starts.agents.items():
        first = mission.steps[0].before.agents[a]
        if (first.p_WC, first.posture, first.grasp) != (s.p_WC, s.posture, None):
            found.append(f"{a} does not begin at its start")
    if mission.steps[-1].after != mission.steps[mission.loop].before:
        found.append("the loop does not close")
    for earlier, later in itertools.pairwise(mission.steps):
        if earlier.after != later.before:
            found.append("a step does not begin where the last ended")

    for index, step in enumerate(mission.steps):
        k = order[index]
        before_state = plan.states[k]
        after_state = plan.states[order[index + 1] if index + 1 < len(mission.steps) else order[mission.loop]]
        if step.actions != plan.moves[k]:
            found.append(f"step {index}: actions differ from the plan's")
        acting = {agent: action for action in step.actions for agent in action.agents}
        carried = {action.object: action for action in step.actions if action.kind == "transport"}
        # layouts: symbolic state, spheres apart and inside
        for when, layout, state in (
            ("before", step.before, before_state),
            ("after", step.after, after_state),
        ):
            agents, objects = _spheres(layout, scenario, geometry)
            where = f"step {index} {when}"
            for i, a in enumerate(scenario.agent_names):
                held = layout.agents[a].grasp[0] if layout.agents[a].grasp else None
                if held != state.grasps[i]:
                    found.append(f"{where}: {a} grasps {held}")
                inside(a, agents[a], state.agents[i], where)
                if held:
                    o = option(layout, a)
                    expected = [p + d for p, d in zip(layout.objects[held], o.p_OoC_grasp, strict=True)]
                    if math.dist(expected, layout.agents[a].p_WC) > 1e-9:
                        found.append(f"{where}: {a} is not at its grasp")
                    if layout.agents[a].posture != o.standoff_posture:
                        found.append(f"{where}: {a} holds in a wrong posture")
                elif all(
                    abs(layout.agents[a].p_WC[2] - p[2]) > 1e-9
                    for n, p in geometry.postures[a].items()
                    if n == layout.agents[a].posture
                ):
                    found.append(f"{where}: {a} at a height that is not its posture's")
            for j, o in enumerate(scenario.object_names):
                inside(o, objects[o], state.objects[j], where)
                if abs(layout.objects[o][2] - geometry.object_height[o]) > 1e-9:
                    found.append(f"{where}: {o} not on the floor")
            for a, b in itertools.combinations(agents, 2):
                apart(a, agents[a], b, agents[b], where)
            for a, b in itertools.combinations(objects, 2):
                apart(a, objects[a], b, objects[b], where)
            for a, o in itertools.product(agents, objects):
                if not holder_of(layout, a, o):
                    apart(a, agents[a], o, objects[o], where)
        # who moves, and how
        for a in scenario.agent_names:
            old, new = step.before.agents[a], step.after.agents[a]
            action = acting.get(a)
            if action is None and old != new:
                found.append(f"step {index}: {a} moves without an action")
            if action is not None and action.kind == "travel" and new.posture != old.posture:
                options = [opt for key, opts in geometry.grasps.items() if key[0] == a for opt in opts]
                ends = [
                    [p + d for p, d in zip(step.after.objects[o], opt.p_OoC_standoff, strict=True)]
                    for o in scenario.object_names
                    for opt in options
                    if opt.standoff_posture == new.posture
                ]
                if all(math.dist(end, new.p_WC) > 1e-9 for end in ends):
                    found.append(f"step {index}: {a} changes its posture away from any stand-off")
            if action is not None and action.kind == "transport" and old.grasp != new.grasp:
                found.append(f"step {index}: {a} changes its grasp while carrying")
            if action is not None and action.kind == "release":
                o = option(step.before, a)
                end = [p + d for p, d in zip(step.before.objects[action.object], o.p_OoC_standoff, strict=True)]
                if math.dist(end, new.p_WC) > 1e-9 or new.posture != o.standoff_posture:
                    found.append(f"step {index}: {a} does not withdraw to its stand-off")
            if action is not None and action.kind == "grasp":
                o = option(step.after, a)
                end = [p + d for p, d in zip(step.after.objects[action.object], o.p_OoC_standoff, strict=True)]
                stand = step.standoffs[a]
                if math.dist(end, stand.p_WC) > 1e-9 or stand.posture != o.standoff_posture or stand.grasp:
                    found.append(f"step {index}: {a} does not approach from its stand-off")
        for o in scenario.object_names:
            if o not in carried and step.before.objects[o] != step.after.objects[o]:
                found.append(f"step {index}: {o} moves by itself")
        if set(step.standoffs) != {a for a, action in acting.items() if action.kind == "grasp"}:
            found.append(f"step {index}: wrong stand-offs")
        # what is larger than a body during the move
        for when, layout in (("before", step.before), ("mid", step.after)):
            where = f"step {index} {when} the move"
            _, objects = _spheres(layout, scenario, geometry)
            balls = []  # (body or bodies, object in touch with, reaching, centre, radius, covering radius)
            for a in scenario.agent_names:
                r, action = geometry.agent_radius[a], acting.get(a)
                kind = action.kind if action else None
                if kind in ("grasp", "release"):
                    holding = step.after if kind == "grasp" else step.before
                    o = option(holding, a)
                    grasp = holding.agents[a].p_WC
                    end = step.standoffs[a].p_WC if kind == "grasp" else step.after.agents[a].p_WC
                    cover = math.hypot(r, math.dist(o.p_OoC_grasp, o.p_OoC_standoff) / 2.0)
                    drives = kind == "grasp" and when == "before" and math.dist(end, step.before.agents[a].p_WC) > 1e-9
                    if drives:
                        balls.append(({a}, None, False, layout.agents[a].p_WC, r, r))
                    else:
                        if kind == "grasp":
                            inside(a, (end, r), action.start, where)
                        balls += [({a}, action.object, True, p, r, cover) for p in (end, grasp)]
                else:
                    held = layout.agents[a].grasp[0] if layout.agents[a].grasp else None
                    balls.append(({a}, held, False, layout.agents[a].p_WC, r, r))
            for o in scenario.object_names:
                if o in carried:
                    team, r = {o, *carried[o].agents}, geometry.team_radius[o]
                    balls.append((team, o, True, layout.objects[o], r, r))
                    if when == "mid":
                        inside(f"team of {o}", (layout.objects[o], r), carried[o].goal, where)
                    else:
                        if math.hypot(*layout.objects[o]) + r > scenario.workspace_radius:
                            found.append(f"{where}: team of {o} leaves the workspace")
                        for region in scenario.regions:
                            if region.name != carried[o].start:
                                apart(
                                    o,
                                    (layout.objects[o], r),
                                    region.name,
                                    (region.centre, region.radius),
                                    where,
                                )
                else:
                    balls.append(({o}, None, False, layout.objects[o], objects[o][1], objects[o][1]))
            for (a, at, ra, p, r, cover_a), (b, bt, rb, q, s, cover_b) in itertools.combinations(balls, 2):
                if a & b or (at in b) or (bt in a):
                    continue
                if (ra or rb) and at is not None and at == bt:
                    apart("/".join(sorted(a)), (p, r), "/".join(sorted(b)), (q, s), where)
                else:
                    apart("/".join(sorted(a)), (p, cover_a), "/".join(sorted(b)), (q, cover_b), where)
    return found


def random_states(scenario: Scenario, start: State, fits, rng, length: int) -> list[State]:
    """A random walk of Def. 5 in which everything fits, as far as it gets."""
    states = [start]
    for _ in range(40 * length):
        if len(states) > length:
            break
        following = _random_successor(scenario, states[-1], rng)
        if following != states[-1] and _fits(scenario, states[-1], following, fits):
            states.append(following)
    return states


def _random_successor(scenario: Scenario, state: State, rng) -> State:
    agents, objects, grasps = list(state.agents), list(state.objects), list(state.grasps)
    carried = set()
    for j, name in enumerate(scenario.object_names):
        team = [i for i, held in enumerate(state.grasps) if held == name]
        if len(team) >= 2 and rng.random() < 0.6:
            objects[j] = rng.choice(scenario.region_names)
            if objects[j] != state.objects[j]:
                carried.add(name)
                for i in team:
                    agents[i] = objects[j]
    for i, held in enumerate(state.grasps):
        here = [
            name
            for name, region in zip(scenario.object_names, state.objects, strict=True)
            if region == state.agents[i] and name not in carried
        ]
        if held is not None and held not in carried and rng.random() < 0.15:
            grasps[i] = None
        elif held is None and here and rng.random() < 0.6:
            grasps[i] = rng.choice(here)
        elif held is None and rng.random() < 0.5:
            agents[i] = rng.choice(scenario.region_names)
    return State(tuple(agents), tuple(objects), tuple(grasps))


def _fits(scenario: Scenario, before: State, after: State, fits) -> bool:
    carried = frozenset(
        name for name, a, b in zip(scenario.object_names, before.objects, after.objects, strict=True) if a != b
    )
    for state in (before, after):
        for region in scenario.regions:
            here = [i for i, name in enumerate(state.agents) if name == region.name]
            objects = tuple(
                name for name, at in zip(scenario.object_names, state.objects, strict=True) if at == region.name
            )
            names = scenario.agent_names
            content = Content(
                tuple(names[i] for i in here if state.grasps[i] is None),
                objects,
                tuple((names[i], state.grasps[i]) for i in here if state.grasps[i] is not None),
                carried & set(objects),
            )
            if not fits(region, content):
                return False
    return True


def there_and_back(states: Sequence[State], loop: int) -> list[State]:
    """The states of a lasso: to the last state and the same way back to state `loop`."""
    return [*states, *reversed(states[loop + 1 : -1])]


TOOLS = SimpleNamespace(
    scenario=make_scenario,
    geometry=make_geometry,
    plan=make_plan,
    violations=violations,
    random_states=random_states,
    there_and_back=there_and_back,
)
"""What the tests of this folder share: makers of input, and the checker."""


@pytest.fixture(scope="session")
def tools() -> SimpleNamespace:
    return TOOLS


@pytest.fixture
def case_ii(tools) -> SimpleNamespace:
    """Scenario, geometry, starts and the plan of Table 2."""
    scenario = make_scenario()
    geometry = make_geometry(scenario)
    states = [
        State(("pi1", "pi3", "pi4"), ("pi2", "pi1"), (None, None, None)),
        State(("pi2", "pi1", "pi1"), ("pi2", "pi1"), (None, None, None)),
        State(("pi2", "pi1", "pi1"), ("pi2", "pi1"), (None, "o2", "o2")),
        State(("pi2", "pi3", "pi3"), ("pi2", "pi3"), (None, "o2", "o2")),
        State(("pi2", "pi3", "pi3"), ("pi2", "pi3"), (None, "o2", None)),
        State(("pi2", "pi3", "pi2"), ("pi2", "pi3"), (None, "o2", None)),
        State(("pi2", "pi3", "pi2"), ("pi2", "pi3"), ("o1", "o2", "o1")),
        State(("pi1", "pi3", "pi1"), ("pi1", "pi3"), ("o1", "o2", "o1")),
        State(("pi4", "pi3", "pi4"), ("pi4", "pi3"), ("o1", "o2", "o1")),
    ]
    plan = make_plan(scenario, states, 7)
    return SimpleNamespace(scenario=scenario, geometry=geometry, starts=check_starts(scenario, geometry), plan=plan)
