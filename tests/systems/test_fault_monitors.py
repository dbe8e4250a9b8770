"""Monitors of faults see what measurements and commands make of each other; they stay silent while these agree."""

from __future__ import annotations

import numpy as np
import pytest
from pydrake.common.value import Value

from drake_ltl.faults.weights import weighed
from drake_ltl.multibody.crew import CrewModel
from drake_ltl.systems.doors import Doors
from drake_ltl.systems.fault_monitors import (
    ClockMonitor,
    DoorMonitor,
    DriveMonitor,
    GripMonitor,
    LoadMonitor,
    MotionMonitor,
    ObjectMonitor,
)
from drake_ltl.systems.fault_monitors.door import CLOSED_TIME
from drake_ltl.systems.fault_monitors.load import OFF_TIME, STUCK_TIME, WINDOW
from drake_ltl.systems.program import all_welds
from drake_ltl.systems.progress import AgentSignals, Progress
from drake_ltl.systems.signals import NO_GRASP, Mode, Phase

DT = 0.005
REST = {"first_step": 0, "ignored": frozenset()}
NEW = np.zeros(1)
"""Age of what is measured at once [s]."""


@pytest.fixture(scope="module")
def x(places):
    """Arms bent, all at rest, crates on the floor."""
    x = np.zeros(places.size)
    x[places.q] = np.tile([0.0, 0.0, 0.5, 0.8], 3) + np.repeat([0.0, 10.0, 20.0], 4) * np.tile([1.0, 0.0, 0.0, 0.0], 3)
    for index, rows in enumerate(places.pose.values()):
        x[rows] = [1.0, 0.0, 0.0, 0.0, 3.0 * index, 5.0, 0.25]
    return x


def progress(modes=(Mode.HOLD,) * 3, grasps=(NO_GRASP,) * 3) -> Progress:
    zero = np.zeros(4)
    agents = tuple(AgentSignals(m, zero, np.zeros(10), g) for m, g in zip(modes, grasps, strict=True))
    return Progress(4, Phase.NAVIGATE, 0.0, 0, np.zeros(18), agents)


class Watched:
    """A monitor that looks whenever it is told what it sees."""

    def __init__(self, monitor):
        self.monitor, self.context = monitor, monitor.CreateDefaultContext()
        self.looks, self.told = 0, None

    def look(self, told: Progress, **vectors) -> list[str]:
        self.context.SetTime(self.looks * DT)
        self.looks += 1
        for name, value in vectors.items():
            self.monitor.GetInputPort(name).FixValue(self.context, value)
        if told is not self.told:  # FixValue copies: what it has fixed stays the same Progress
            self.told = told
            self.monitor.get_progress_input_port().FixValue(self.context, Value(told))
        return [violation.what for violation in self.monitor.Look(self.context)]


def test_drives_that_give_what_is_asked_are_well(places, case_ii, models, x):
    watched, told = Watched(DriveMonitor(places, case_ii, models, **REST)), progress()
    asked = np.full(12, 5.0)
    assert watched.look(told, state=x, torque=asked, delivered=asked) == []
    weak = np.r_[[105.0] * 4, [5.0] * 4, [105.0] * 4]
    (what,) = watched.look(told, state=x, torque=np.full(12, 105.0), delivered=weak)
    assert "the drives of a2 give less torque" in what


def test_beyond_their_limits_drives_owe_nothing(places, case_ii, models, x):
    watched = Watched(DriveMonitor(places, case_ii, models, **REST))
    limits = np.concatenate([model.effort_limits for model in models.agents.values()])
    assert watched.look(progress(), state=x, torque=3.0 * limits, delivered=limits) == []


def moving(case_ii, places, x, torques):
    """States at each torque, as a discrete plant steps."""
    crew = CrewModel(case_ii.agents)
    x, n = x.copy(), len(torques[0])
    for torque in torques:
        yield x.copy()
        q, qd = x[places.q], x[places.qd]
        crew.set_state(q, qd)
        bias = crew.inverse_dynamics(np.zeros(n))
        inertia = np.column_stack([crew.inverse_dynamics(e) - bias for e in np.eye(n)])
        x[places.qd] = qd + DT * np.linalg.solve(inertia, torque - bias)
        x[places.q] = q + DT * x[places.qd]


def test_agents_that_move_as_torques_move_them_are_well(places, case_ii, models, x):
    watched, told = Watched(MotionMonitor(places, case_ii, models, **REST)), progress([Mode.TRANSITION] * 3)
    torque = np.tile([3.0, -2.0, 4.0, 2.0], 3)
    states = moving(case_ii, places, x, [torque] * 20)
    assert [w for s in states for w in watched.look(told, state=s, torque=torque, age=NEW)] == []


@pytest.mark.parametrize(("stamped", "accused"), [(4, 0), (0, 3)])
def test_agents_that_are_seen_late_are_held_against_the_torques_of_then(places, case_ii, models, x, stamped, accused):
    """A force that grows by 300 N/s is 6 N less 20 ms ago: enough to accuse everybody, were it not for the stamps."""
    late, watched, told = 4, Watched(MotionMonitor(places, case_ii, models, **REST)), progress([Mode.TRANSITION] * 3)
    torques = [np.tile([1.5 * k, -2.0, 4.0, 2.0], 3) for k in range(60)]
    states, age = list(moving(case_ii, places, x, torques)), np.array([stamped * DT])
    looks = [{"state": states[max(0, k - late)], "torque": torque, "age": age} for k, torque in enumerate(torques)]
    assert len([what for look in looks for what in watched.look(told, **look)]) == accused


def test_samples_that_come_later_than_damping_bears_are_noticed_within_20_ms(places, case_ii, models, x):
    for age, wanted in ((0.010, 0), (0.020, 1)):
        watched = Watched(ClockMonitor(places, case_ii, models, **REST))
        told = progress()
        found = [what for _ in range(5) for what in watched.look(told, state=x, age=np.array([age]))]
        assert len(found) == wanted
    watched = Watched(ClockMonitor(places, case_ii, models, **REST))
    one_late = [what for k in range(9) for what in watched.look(told, state=x, age=np.array([0.02 * (k % 2)]))]
    assert one_late == []


def test_who_stands_still_under_a_torque_is_noticed_within_a_fifth_of_a_second(places, case_ii, models, x):
    watched, told = Watched(MotionMonitor(places, case_ii, models, **REST)), progress([Mode.TRANSITION] * 3)
    crew = CrewModel(case_ii.agents)
    crew.set_state(x[places.q], x[places.qd])
    torque = crew.inverse_dynamics(np.zeros(12)) + np.eye(12)[4] * 20.0  # a2 is driven along x
    found = [what for _ in range(40) for what in watched.look(told, state=x, torque=torque, age=NEW)]
    assert len(found) == 1
    assert "a2 does not move as its torques should move it" in found[0]


def test_nobody_is_accused_of_what_the_supervisor_has_just_changed(places, case_ii, models, x):
    watched = Watched(MotionMonitor(places, case_ii, models, **REST))
    crew = CrewModel(case_ii.agents)
    crew.set_state(x[places.q], x[places.qd])
    torque = crew.inverse_dynamics(np.zeros(12)) + 20.0 * np.eye(12)[4]
    look = {"state": x, "torque": torque, "age": NEW}
    found = [what for _ in range(40) for what in watched.look(progress([Mode.TRANSITION] * 3), **look)]
    assert found == []  # another Progress at every look


@pytest.mark.parametrize("force", [0.0, 1.0])
def test_who_stands_still_while_it_should_carry_is_noticed(places, case_ii, models, x, force):
    """But not who rests where nothing drives it, having arrived before others."""
    watched = Watched(MotionMonitor(places, case_ii, models, **REST))
    told = progress([Mode.TRANSPORT, Mode.TRANSPORT, Mode.HOLD], (0, 1, NO_GRASP))
    swinging = x.copy()
    swinging[places.qd[:4]] = 1e-3
    torque = np.tile([0.0, force, 0.0, 0.0], 3)
    found = [what for _ in range(30) for what in watched.look(told, state=swinging, torque=torque, age=NEW)]
    assert len([what for what in found if "a2 stands still" in what]) == (force > 0.0)
    assert not any("a1" in what for what in found)


def test_a_grasp_that_gapes_is_lost(places, case_ii, models, x):
    welds = all_welds(models)
    index = next(i for i, weld in enumerate(welds) if weld.agent == "a1" and weld.object == "o1")
    told = progress([Mode.TRANSPORT, Mode.HOLD, Mode.HOLD], (index, NO_GRASP, NO_GRASP))
    held = x.copy()
    q = models.grasp(welds[index].agent, "o1", welds[index].option).q.copy()
    q[:2] += x[places.pose["o1"]][4:6]
    held[places.q[:4]] = q
    watched = Watched(GripMonitor(places, case_ii, models, welds, **REST))
    assert [what for _ in range(60) for what in watched.look(told, state=held)] == []
    slipped = held.copy()
    slipped[places.q[0]] += 0.01
    found = [what for _ in range(60) for what in watched.look(told, state=slipped)]
    assert found == ["a1 has lost its grasp of o1"]


@pytest.mark.parametrize(("speed", "grasps", "expected"), [(0.2, 0, 1), (0.2, 1, 0), (0.01, 0, 0)])
def test_objects_that_move_by_themselves_are_noticed(places, case_ii, models, x, speed, grasps, expected):
    welds = all_welds(models)
    index = next(i for i, weld in enumerate(welds) if weld.object == "o2")
    told = progress(grasps=(index if grasps else NO_GRASP, NO_GRASP, NO_GRASP))
    x = x.copy()
    x[places.velocity["o2"]] = [0.0, 0.0, 0.0, speed, 0.0, 0.0]
    watched = Watched(ObjectMonitor(places, case_ii, welds, **REST))
    assert len([what for _ in range(40) for what in watched.look(told, state=x)]) == expected


def carried(case_ii, places, models, x, mass, *, height, floor=0.0):
    """(state, torques) of 150 looks: a1 and a2 squeeze o1 and carry it off `height` [m] above the floor, which bears
    `floor` [N], ever faster; a3 stands."""
    crew, x, chance = CrewModel(case_ii.agents), x.copy(), np.random.default_rng(0)
    x[places.qd[:8]] = 0.1  # nobody is held fast
    x[places.pose["o1"]][6] = models.objects["o1"].height + height
    qdd = np.r_[chance.normal(0.0, 0.3, 8), np.zeros(4)]
    a_z, share, squeeze = 0.3, 0.3, 20.0 * chance.normal(size=6)
    f = np.array([*chance.normal(size=5), mass * (9.81 + a_z) - floor])
    for _ in range(150):
        crew.set_state(x[places.q], x[places.qd])
        torque = crew.inverse_dynamics(qdd)
        for name, wrench in (("a1", share * f + squeeze), ("a2", (1.0 - share) * f - squeeze)):
            torque[crew.rows[name]] += crew.grasp_jacobian(name).T @ wrench
        yield x.copy(), torque
        x[places.qd] += DT * qdd
        x[places.q] += DT * x[places.qd]
        x[places.velocity["o1"]][5] += DT * a_z


CARRY = progress([Mode.TRANSPORT, Mode.TRANSPORT, Mode.HOLD], (0, 1, NO_GRASP))


@pytest.mark.parametrize("noise", [0.0, 1.0])
@pytest.mark.parametrize(
    ("factor", "height", "floor", "noticed"),
    [
        (1.0, 0.05, 0.0, False),
        (1.1, 0.05, 0.0, False),
        (0.9, 0.05, 0.0, False),
        (1.3, 0.05, 0.0, True),
        (0.7, 0.05, 0.0, True),
        (0.7, 0.0, 0.0, False),  # the floor might bear the rest ...
        (1.3, 0.0, 0.0, True),  # ... and draws at nothing
        (1.3, 0.0, 1.5, False),
    ],
)
def test_a_load_is_weighed_while_it_is_carried(places, case_ii, models, x, noise, factor, height, floor, noticed):
    monitor, chance = LoadMonitor(places, case_ii, models, **REST), np.random.default_rng(1)
    watched, mass, sigma = Watched(monitor), factor * models.objects["o1"].mass, np.full(len(x), 2e-4)
    for rows in (places.qd, *places.velocity.values()):
        sigma[rows] = 2e-3
    for state, torque in carried(case_ii, places, models, x, mass, height=height, floor=floor):
        seen = state + noise * sigma * chance.normal(size=len(x))
        watched.look(CARRY, state=seen, delivered=torque, age=NEW)
    found = monitor.violations(watched.context)
    assert [violation.what for violation in found] == ["o1 does not weigh 0.5 kg, as is believed"] * noticed
    if noticed:
        assert found[0].value == pytest.approx(mass, rel=0.05 if noise else 1e-9)
        assert found[0].time <= WINDOW + OFF_TIME + 2.0 * DT


def test_what_was_weighed_is_believed(places, case_ii, models, x):
    heavier = weighed(models, {"o1": 0.65})
    for models_now, noticed in ((models, 1), (heavier, 0)):
        watched = Watched(LoadMonitor(places, case_ii, models_now, **REST))
        looks = carried(case_ii, places, models, x, 0.65, height=0.05)
        found = [what for s, t in looks for what in watched.look(CARRY, state=s, delivered=t, age=NEW)]
        assert len(found) == noticed


def test_who_is_held_fast_weighs_nothing(places, case_ii, models, x):
    """Brakes bear part of the load."""
    watched = Watched(LoadMonitor(places, case_ii, models, **REST))
    for state, torque in carried(case_ii, places, models, x, 0.1, height=0.05):
        state[places.qd[4:8]] = 1e-7
        assert watched.look(CARRY, state=state, delivered=torque, age=NEW) == []


@pytest.mark.parametrize(("share", "height", "noticed"), [(1.0, 0.0, 1), (0.99, 0.0, 0), (1.0, 0.05, 0)])
def test_what_all_the_torque_does_not_lift_is_too_heavy(places, case_ii, models, x, share, height, noticed):
    watched, x = Watched(LoadMonitor(places, case_ii, models, **REST)), x.copy()
    x[places.pose["o1"]][6] = models.objects["o1"].height + height
    limits = np.concatenate([model.effort_limits for model in models.agents.values()])
    torque = limits * np.tile([1.0, 1.0, -share, 0.5], 3)  # a base at its limit proves nothing
    asked = {"state": x, "delivered": torque, "age": NEW}
    found = [what for _ in range(round(STUCK_TIME / DT) + 2) for what in watched.look(CARRY, **asked)]
    assert found == ["o1 is not lifted by all the torque that its carriers have"] * noticed


def test_a_door_that_closes_is_noticed_once_its_contact_rests(places, case_ii, x):
    doors, told = Doors(case_ii.region_names), progress()
    context = doors.CreateDefaultContext()
    contact = doors.get_closed_output_port()
    monitor = DoorMonitor(places, case_ii, **REST)
    watched = Watched(monitor)
    bounce = np.eye(len(case_ii.regions))[0]
    assert watched.look(told, state=x, closed=contact.Eval(context)) == []
    assert [what for _ in range(5) for what in watched.look(told, state=x, closed=bounce)] == []
    assert watched.look(told, state=x, closed=contact.Eval(context)) == []
    closed_at = watched.looks * DT
    doors.Close(context, "pi2")
    found = [what for _ in range(40) for what in watched.look(told, state=x, closed=contact.Eval(context))]
    assert found == ["the door of pi2 has closed"]
    (seen,) = monitor.violations(watched.context)
    assert seen.who == ("pi2",)
    assert seen.time - closed_at == pytest.approx(CLOSED_TIME, abs=1.5 * DT)


def test_a_door_that_is_known_to_be_closed_is_not_noticed_again(places, case_ii, x):
    watched, told = Watched(DoorMonitor(places, case_ii, first_step=0, ignored=frozenset({"pi2"}))), progress()
    closed = np.ones(len(case_ii.regions))
    found = [what for _ in range(40) for what in watched.look(told, state=x, closed=closed)]
    assert sorted(found) == [f"the door of {name} has closed" for name in case_ii.region_names if name != "pi2"]


def test_what_is_known_is_not_noticed_again(places, case_ii, models, x):
    monitor = DriveMonitor(places, case_ii, models, first_step=7, ignored=frozenset({"a1"}))
    watched = Watched(monitor)
    assert watched.look(progress(), state=x, torque=np.r_[[100.0] * 4, [0.0] * 8], delivered=np.zeros(12)) == []
    (seen,) = watched.look(progress(), state=x, torque=np.r_[[0.0] * 4, [100.0] * 8], delivered=np.zeros(12))[:1]
    assert "a2" in seen
    assert monitor.violations(watched.context)[0].step == 11  # of the whole run
