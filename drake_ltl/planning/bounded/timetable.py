"""From errands to steps: everybody acts as soon as the order of the errands allows it.

A team grasps when all of it, and the object, are there; who is not wanted at the object's next transport releases it
at once. Who carries an object last in the suffix and first in its next round keeps hold of it in between.
"""

from __future__ import annotations

from collections.abc import Sequence

from drake_ltl.planning.bounded.errands import Agenda, Errand
from drake_ltl.planning.bounded.problem import Problem, Run
from drake_ltl.planning.bounded.routes import Routes
from drake_ltl.planning.plan import State


def timetable(problem: Problem, routes: Routes, agenda: Agenda, *, together: bool = True) -> Run:
    """A lasso of Def. 5 that does its errands in their order; whether it fits and its word remain to be checked.

    Args:
        problem: the problem.
        routes: between errands.
        agenda: the errands.
        together: whether errands that have nobody in common may be done at the same time; otherwise one begins when
            the one before has ended and everybody releases what was carried, which takes more steps and less room.
    """
    diary = _Diary(problem, routes, agenda, together)
    for phase in range(2):
        for errand in agenda[phase]:
            diary.do(errand)
        diary.end_phase()
    return diary.run()


class _Diary:
    """Where everybody is and what it grasps, at each time so far."""

    def __init__(self, problem: Problem, routes: Routes, agenda: Agenda, together: bool):
        self._problem, self._routes, self._together = problem, routes, together
        n, start, names = problem.n_agents, problem.start, problem.scenario.object_names
        self._agents = [[k] for k in problem.starts[:n]]
        """[i][t]: agent i's region."""
        self._objects = [[k] for k in problem.starts[n:]]
        self._grasps: list[list[int | None]] = [[None if g is None else names.index(g)] for g in start.grasps]
        """[i][t]: what agent i grasps."""
        self._meetings = [routes.meeting(i, agenda) for i in range(n)]
        self._keeps = [_keeps(agenda[1], i) if together else None for i in range(n)]
        """[i]: what agent i grasps whenever a round of the suffix begins."""
        self._left = [_Left(errands) for errands in agenda]
        self._phase, self._loop = 0, 0
        for i in range(n):
            self._release_unless_wanted(i)

    def do(self, errand: Errand) -> None:
        """Everybody comes, grasps and carries."""
        self._left[self._phase].done += 1
        if not self._together:
            self._wait_for(max(map(len, (*self._agents, *self._objects))))
        for i in errand.team:
            if errand.object is None or self._grasps[i][-1] != errand.object:
                self._go(i, errand.start)
        if errand.object is not None:
            self._carry(errand, errand.object)

    def end_phase(self) -> None:
        """All come to where the suffix begins, at the same time."""
        for i, (meeting, kept) in enumerate(zip(self._meetings, self._keeps, strict=True)):
            if self._grasps[i][-1] is None:
                self._go(i, meeting)
            if kept is not None and self._grasps[i][-1] is None:
                self._grasp(i, kept)
        end = max(map(len, (*self._agents, *self._objects)))
        if self._phase and end == self._loop + 1:
            end += 1
        self._wait_for(end)
        if not self._phase:
            self._phase, self._loop = 1, end - 1

    def run(self) -> Run:
        """The lasso; the last state is the one to which it leads back."""
        scenario = self._problem.scenario
        regions, objects = scenario.region_names, scenario.object_names

        def state(t: int) -> State:
            grasps = (self._grasps[i][t] for i in range(len(self._agents)))
            return State(
                tuple(regions[places[t]] for places in self._agents),
                tuple(regions[places[t]] for places in self._objects),
                tuple(None if j is None else objects[j] for j in grasps),
            )

        return tuple(state(t) for t in range(len(self._agents[0]) - 1)), self._loop

    # ---- single acts

    def _go(self, i: int, goal: int) -> None:
        for region in self._routes.path(i, self._agents[i][-1], goal):
            self._agents[i].append(region)
            self._grasps[i].append(None)

    def _stay(self, i: int, length: int) -> None:
        """Until the agent's days are so many."""
        extra = length - len(self._agents[i])
        self._agents[i] += self._agents[i][-1:] * extra
        self._grasps[i] += self._grasps[i][-1:] * extra

    def _grasp(self, i: int, obj: int) -> None:
        """As soon as the object has come."""
        self._stay(i, len(self._objects[obj]))
        self._agents[i].append(self._agents[i][-1])
        self._grasps[i].append(obj)

    def _release_unless_wanted(self, i: int) -> None:
        obj = self._grasps[i][-1]
        if obj is None or self._is_wanted(i, obj):
            return
        self._stay(i, len(self._objects[obj]))
        self._agents[i].append(self._agents[i][-1])
        self._grasps[i].append(None)

    def _carry(self, errand: Errand, obj: int) -> None:
        for i in errand.team:
            if self._grasps[i][-1] is None:
                self._grasp(i, obj)
        begin = max(len(self._objects[obj]), *(len(self._agents[i]) for i in errand.team))
        while any(self._holds(i, obj, begin - 1) for i in range(len(self._agents)) if i not in errand.team):
            begin += 1
        self._objects[obj] += self._objects[obj][-1:] * (begin - len(self._objects[obj])) + [errand.goal]
        for i in errand.team:
            self._stay(i, begin)
            self._agents[i].append(errand.goal)
            self._grasps[i].append(obj)
        for i in errand.team:
            self._release_unless_wanted(i)

    def _holds(self, i: int, obj: int, time: int) -> bool:
        return time < len(self._grasps[i]) and self._grasps[i][time] == obj

    def _is_wanted(self, i: int, obj: int) -> bool:
        """Whether what the agent does next is the next transport of the object that it grasps."""
        if not self._together:
            return False
        mine, its = self._left[self._phase].next(i, obj)
        if mine is None and its is None:
            return self._keeps[i] == obj
        return mine is not None and mine == its

    def _wait_for(self, length: int) -> None:
        for i in range(len(self._agents)):
            self._stay(i, length)
        for places in self._objects:
            places += places[-1:] * (length - len(places))


class _Left:
    """What is left of the errands of a phase."""

    def __init__(self, errands: Sequence[Errand]):
        self._errands, self.done = errands, 0

    def next(self, agent: int, obj: int) -> tuple[int | None, int | None]:
        """Indices of the next errand of an agent and of the next one of an object."""
        left = range(self.done, len(self._errands))
        mine = next((n for n in left if agent in self._errands[n].team), None)
        return mine, next((n for n in left if self._errands[n].object == obj), None)


def _keeps(suffix: Sequence[Errand], agent: int) -> int | None:
    """The object that an agent is the first and the last to carry in each round, with nothing in between rounds."""
    mine = [errand for errand in suffix if agent in errand.team]
    if not mine or mine[0].object is None or mine[0].object != mine[-1].object:
        return None
    its = [errand for errand in suffix if errand.object == mine[0].object]
    return mine[0].object if mine[0] is its[0] and mine[-1] is its[-1] else None
