"""Places for all bodies at every step of a plan: the procedure P_s of the paper, over the whole run at once.

What stands in a region stays where it is when somebody arrives, and an object set down now is in the way later.
So places are chosen for all stays together, by a search over finite lists of places.
"""

from __future__ import annotations

from drake_ltl.errors import PlacementError
from drake_ltl.planning.backjumping import Assignment, DeadEndError, Search
from drake_ltl.planning.geometry import Geometry, Vector3
from drake_ltl.planning.mission import Layout, Mission, PlacedStep, Stand
from drake_ltl.planning.places import Places, Quantity
from drake_ltl.planning.plan import Action, Plan
from drake_ltl.planning.rules import Rules
from drake_ltl.planning.spheres import MARGINS
from drake_ltl.planning.stays import Stays, Timeline
from drake_ltl.planning.ways import costs
from drake_ltl.scenario.model import Scenario
from drake_ltl.scenario.starts import Starts


def place(plan: Plan, scenario: Scenario, geometry: Geometry, starts: Starts) -> Mission:
    """Place every body at every state of the plan's lasso.

    Bodies keep the largest of `MARGINS` that works. If the loop cannot be closed because a body would have to
    come back to exactly its given start, its first round is made part of the prefix.

    Raises:
        PlacementError: if no places are found; `step` is the index of the move that no try got beyond.
    """
    for margin in MARGINS:
        for rounds in (0, 1):
            timeline = Timeline.of(plan, scenario.agent_names, scenario.object_names, rounds=rounds)
            try:
                return _place(plan, timeline, scenario, geometry, starts, margin)
            except DeadEndError as error:
                failure = _failure(plan, timeline, error)
    raise failure


def _place(
    plan: Plan, timeline: Timeline, scenario: Scenario, geometry: Geometry, starts: Starts, margin: float
) -> Mission:
    places = Places(scenario, geometry, starts, Stays(timeline))
    rules = Rules(places, scenario.workspace_radius, margin).constraints()
    values: Assignment = list(Search(places.sizes, rules, costs(places)).solve())
    layouts = [_layout(places, values, time) for time in range(len(timeline.states))]
    steps = tuple(
        PlacedStep(actions, layouts[move], layouts[timeline.after(move)], _standoffs(places, values, move, actions))
        for move, actions in enumerate(timeline.moves)
    )
    return Mission(plan, steps, timeline.loop)


def _failure(plan: Plan, timeline: Timeline, error: DeadEndError) -> PlacementError:
    reason = error.reasons[-1]
    step = timeline.plan_moves[reason.step]
    actions = "; ".join(_describe(action) for action in plan.moves[step]) or "all wait"
    message = f"step {step + 1} ({actions}), whatever places are tried: {error}"
    bodies = frozenset().union(*(reason.bodies for reason in error.reasons))
    return PlacementError(message, step, reason.region, sorted(bodies))


def _layout(places: Places, values: Assignment, time: int) -> Layout:
    timeline = places.stays.timeline
    stands = {}
    for name in timeline.agents:
        stay = places.stays.of_agent(name, time)
        grasp = (stay.held, places.option(stay, values, time).name) if stay.held else None
        stands[name] = Stand(_at(places.agent(name, time), values), places.posture(stay, values, time), grasp)
    origins = {name: _at(places.object(name, time), values) for name in timeline.objects}
    return Layout(stands, origins, {name: places.headings.at(name, time) for name in timeline.objects})


def _standoffs(places: Places, values: Assignment, move: int, actions: tuple[Action, ...]) -> dict[str, Stand]:
    after = places.stays.timeline.after(move)
    grasping = [action.agents[0] for action in actions if action.kind == "grasp"]
    holds = {name: places.stays.of_agent(name, after) for name in grasping}
    return {
        name: Stand(_at(places.standoff(hold, after), values), places.option(hold, values, after).standoff_posture)
        for name, hold in holds.items()
    }


def _at(point: Quantity, values: Assignment) -> Vector3:
    x, y, z = point.value(values)
    return float(x), float(y), float(z)


def _describe(action: Action) -> str:
    who = ", ".join(action.agents)
    if action.kind == "travel":
        return f"{who} from {action.start} to {action.goal}"
    if action.kind == "transport":
        return f"{who} with {action.object} from {action.start} to {action.goal}"
    return f"{who} {action.kind}s {action.object} in {action.start}"
