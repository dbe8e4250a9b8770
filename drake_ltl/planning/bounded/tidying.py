"""The same moves with fewer steps and grasps: what J does not see, but ties are decided by.

Letters tell where members are and not who grasps what, so leaving out grasps in vain changes no word. Taking a
step earlier does, and so does waiting less; formulas have the last say on both.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from drake_ltl.planning.bounded.problem import Run
from drake_ltl.planning.plan import State

IsLasso = Callable[[Run], bool]
"""Whether a run of Def. 5 fits and satisfies the formulas."""
IsStep = Callable[[State, State], bool]
"""Whether all fits before and after a step."""


def tidied(names: Sequence[str], run: Run, is_lasso: IsLasso, is_step: IsStep, is_over: Callable[[], bool]) -> Run:
    """A lasso of the same cost, with no more steps and actions.

    Args:
        names: of the objects.
        run: a lasso.
        is_lasso: asked of each simpler one.
        is_step: asked of each step that is put together anew.
        is_over: whether to leave it at what has been found.
    """
    simpler = without_vain_grasps(run)
    if simpler != run and is_lasso(simpler):
        run = simpler
    denser = shortened(earlier(names, run, is_step, is_over), is_lasso, is_over)
    return denser if is_lasso(denser) else shortened(run, is_lasso, is_over)


def shortened(run: Run, is_lasso: IsLasso, is_over: Callable[[], bool] = lambda: False) -> Run:
    """A lasso without those repeated states that nothing needs."""
    least = run
    for t in reversed(range(1, len(run[0]) + 1)):
        least = _without(least, t) or least
    if least == run or is_lasso(least):
        return least
    t = 1
    while t <= len(run[0]) and not is_over():
        less = _without(run, t)
        if less is not None and is_lasso(less):
            run = less
        else:
            t += 1
    return run


def _without(run: Run, t: int) -> Run | None:
    """The lasso without state t, if that is the same as the one before; t = T stands for the suffix's first."""
    states, loop = run
    if t == len(states):
        repeats = len(states) - loop > 1 and states[-1] == states[loop]
        return (states[:-1], loop) if repeats else None
    if t > len(states) or states[t] != states[t - 1] or (t > loop and len(states) - loop == 1):
        return None
    return states[:t] + states[t + 1 :], loop - (t <= loop)


def without_vain_grasps(run: Run) -> Run:
    """A lasso in which who grasps an object carries it before letting go."""
    states, loop = run
    following = [*range(1, len(states)), loop]
    grasps = [list(state.grasps) for state in states]
    for i in range(len(states[0].agents)):
        for held in _holds(states, following, i):
            carries = any(states[t].agents[i] != states[following[t]].agents[i] for t in held)
            if 0 not in held and not carries:
                for t in held:
                    grasps[t][i] = None
    return tuple(replace(s, grasps=tuple(g)) for s, g in zip(states, grasps, strict=True)), loop


def _holds(states: tuple[State, ...], following: list[int], i: int) -> list[set[int]]:
    """Sets of times throughout which an agent keeps hold of one object."""
    found: list[set[int]] = []
    for t, after in enumerate(following):
        if states[t].grasps[i] is None:
            continue
        together = {t}
        if states[after].grasps[i] == states[t].grasps[i]:
            together.add(after)
        for other in [held for held in found if held & together]:
            found.remove(other)
            together |= other
        found.append(together)
    return found


def earlier(names: Sequence[str], run: Run, is_step: IsStep, is_over: Callable[[], bool]) -> Run:
    """Acts are put into the step before, and the one before that, while those who act are idle there and all fits.

    Prefix and suffix keep their lengths; states are left over that repeat the one before.
    """
    states, loop = list(run[0]), run[1]
    for last in range(1, len(states)):
        for t in range(last, 0, -1):
            if t == loop or is_over():
                break
            before, after, brought = states[t - 1], (*states, states[loop])[t + 1], False
            for act in _acts(names, states[t], after):
                sooner = act.done(states[t], after)
                if act.is_idle(before, states[t]) and is_step(before, sooner) and is_step(sooner, after):
                    states[t], brought = sooner, True
            if not brought:
                break
    return tuple(states), loop


@dataclass(frozen=True)
class _Act:
    """What an agent, or a team with its object, does in a step; by indices."""

    agents: frozenset[int]
    carried: int | None
    touched: int | None
    """The object that is carried, grasped or released."""

    def is_idle(self, before: State, after: State) -> bool:
        """Whether a step leaves room for this act: its agents do nothing, and nobody else is at its object."""
        if any(before.agents[i] != after.agents[i] or before.grasps[i] != after.grasps[i] for i in self.agents):
            return False
        if self.touched is None or before.objects[self.touched] != after.objects[self.touched]:
            return self.touched is None
        if self.carried is None:
            return True
        obj = next(before.grasps[i] for i in self.agents)
        return all((a == obj) == (b == obj) for a, b in zip(before.grasps, after.grasps, strict=True))

    def done(self, now: State, after: State) -> State:
        """The state now if this act had been done before it."""
        agents = (after if i in self.agents else now for i in range(len(now.agents)))
        grasps = (after if i in self.agents else now for i in range(len(now.agents)))
        objects = (after if j == self.carried else now for j in range(len(now.objects)))
        return State(
            tuple(state.agents[i] for i, state in enumerate(agents)),
            tuple(state.objects[j] for j, state in enumerate(objects)),
            tuple(state.grasps[i] for i, state in enumerate(grasps)),
        )


def _acts(names: Sequence[str], now: State, after: State) -> list[_Act]:
    """All acts of a step."""
    found, teams = [], frozenset[int]()
    for j, (a, b) in enumerate(zip(now.objects, after.objects, strict=True)):
        if a != b:
            team = frozenset(i for i, grasp in enumerate(now.grasps) if grasp == names[j])
            found.append(_Act(team, j, j))
            teams |= team
    for i in set(range(len(now.agents))) - teams:
        held, holds = now.grasps[i], after.grasps[i]
        if held != holds or now.agents[i] != after.agents[i]:
            touched = None if held == holds else names.index(held or holds or "")
            found.append(_Act(frozenset({i}), None, touched))
    return found
