"""All lassos of up to H steps as one constraint model: the rules of Def. 5, the loop and the cost.

Positions are 0 .. H. Steps after the lasso's end are void: nothing changes and no letter is read. So the state at
position H is the one to which the last step leads, and one H covers all shorter lassos.
"""

from __future__ import annotations

from itertools import combinations

from ortools.sat.python import cp_model

from drake_ltl.planning.bounded.cuts import WeakTeam, forbid_team
from drake_ltl.planning.bounded.problem import Problem, exact
from drake_ltl.planning.plan import State
from drake_ltl.scenario.model import PublishedFits

Literal = cp_model.IntVar


class Lassos:
    """The model with its literals, each one a list over positions (or steps) first."""

    def __init__(self, problem: Problem, horizon: int, capacity: PublishedFits | None, *, costs: bool = True):
        """Form the model.

        Args:
            problem: the problem.
            horizon: H.
            capacity: counting rule to be obeyed; None if there is none.
            costs: whether to look for the cheapest lasso; if not, any will do, which is much easier to find.
        """
        self.problem, self.horizon, self.costs = problem, horizon, costs
        self.model = cp_model.CpModel()
        self.true: Literal = self.model.new_constant(1)
        K, N, M = problem.n_regions, problem.n_agents, problem.n_objects
        positions, steps = range(horizon + 1), range(horizon)
        self.free = [[self._literals(K) for _ in range(N)] for _ in positions]
        """[t][i][k]: agent i grasps nothing and is in region k."""
        self.held = [[self._literals(K) for _ in range(N)] for _ in positions]
        """[t][i][k]: agent i grasps something and is in region k."""
        self.grasps = [[self._literals(M) for _ in range(N)] for _ in positions]
        """[t][i][j]"""
        self.at = [[self._literals(K) for _ in range(N + M)] for _ in positions]
        """[t][m][k]: member m (agents, then objects) is in region k."""
        self.carried = [self._literals(M) for _ in steps]
        """[t][j]: object j changes its region in step t."""
        self.active = self._literals(horizon)
        """[t]: step t belongs to the lasso."""
        self.enters = self._literals(horizon)
        """[t]: the suffix begins at position t."""
        self.inside = self._literals(horizon)
        """[t]: it has begun."""
        self._add_states()
        self._add_steps()
        self._add_loop()
        if capacity is not None:
            self._add_capacity(capacity)
        self._cost = self._add_costs() if costs else 0
        if costs:
            self.model.minimize(self._cost * (horizon + 1) + sum(self.active))

    def limit(self, cost: int, *, better: bool) -> None:
        """Ask for a cost of at most this, or less than this."""
        self.model.add(self._cost <= cost - 1 if better else self._cost <= cost)

    def shown(self, t: int, state: State) -> list[Literal]:
        """Literals that together say that the state at position t is this one."""
        scenario, n = self.problem.scenario, self.problem.n_agents
        region, obj = scenario.region_names.index, scenario.object_names.index
        agents = [
            self.free[t][i][region(at)] if grasp is None else self.grasps[t][i][obj(grasp)]
            for i, (at, grasp) in enumerate(zip(state.agents, state.grasps, strict=True))
        ]
        return agents + [self.at[t][n + j][region(at)] for j, at in enumerate(state.objects)]

    # ---- Def. 5

    def _literals(self, n: int) -> list[Literal]:
        return [self.model.new_bool_var("") for _ in range(n)]

    def _add_states(self) -> None:
        """(i): an agent is where the object is that it grasps."""
        model, n = self.model, self.problem.n_agents
        for t in range(self.horizon + 1):
            for at in self.at[t]:
                model.add_exactly_one(at)
            for i in range(n):
                free, held, grasps = self.free[t][i], self.held[t][i], self.grasps[t][i]
                model.add_exactly_one(free + grasps)
                model.add_exactly_one(free + held)
                for k, at in enumerate(self.at[t][i]):
                    model.add(at == free[k] + held[k])
                    for j, grasp in enumerate(grasps):
                        model.add_bool_or([grasp.negated(), self.at[t][n + j][k].negated(), held[k]])
        for literal in self.shown(0, self.problem.start):
            model.add_bool_or([literal])

    def _add_steps(self) -> None:
        """(iii), clauses (1) to (5)."""
        for t in range(self.horizon):
            for i in range(self.problem.n_agents):
                self._add_agent_step(t, i)
            for j in range(self.problem.n_objects):
                self._add_object_step(t, j)
            void = self.active[t]
            for before, after in self._pairs(t, t + 1):
                self.model.add_bool_or([void, before.negated(), after])
        teams = self.problem.strong_teams
        if teams is not None and not self.problem.sum_rule:
            everyone = range(self.problem.n_agents)
            for j, strong in enumerate(teams):
                every = (frozenset(c) for size in range(1, len(everyone) + 1) for c in combinations(everyone, size))
                for weak in set(every) - set(strong):
                    forbid_team(self, WeakTeam(j, weak))

    def _add_agent_step(self, t: int, i: int) -> None:
        """(1, 2) Who grasps or releases stays in its region; (3) and does not do both in one step."""
        for a, b in self._other_regions():
            self.model.add_implication(self.free[t][i][a], self.held[t + 1][i][b].negated())
            self.model.add_implication(self.held[t][i][a], self.free[t + 1][i][b].negated())
        for j, grasp in enumerate(self.grasps[t][i]):
            for other, following in enumerate(self.grasps[t + 1][i]):
                if j != other:
                    self.model.add_implication(grasp, following.negated())

    def _add_object_step(self, t: int, j: int) -> None:
        """(4) What moves an object is the same team before and after; (5) and it is strong enough."""
        model, carried, m = self.model, self.carried[t][j], self.problem.n_agents + j
        for k, before in enumerate(self.at[t][m]):
            after = self.at[t + 1][m][k]
            model.add_bool_or([carried, before.negated(), after])
            model.add_bool_or([carried.negated(), before.negated(), after.negated()])
        team = [self.grasps[t][i][j] for i in range(self.problem.n_agents)]
        for i, before in enumerate(team):
            after = self.grasps[t + 1][i][j]
            model.add_bool_or([carried.negated(), before.negated(), after])
            model.add_bool_or([carried.negated(), before, after.negated()])
        model.add_bool_or([carried.negated(), *team])
        if self.problem.sum_rule:
            zetas, needs = self.problem.powers
            total = sum(zeta * grasps for zeta, grasps in zip(zetas, team, strict=True))
            model.add(total >= needs[j] * carried)

    def _pairs(self, t: int, other: int) -> list[tuple[Literal, Literal]]:
        """The literals that make up a state, at two positions."""
        groups = zip(
            (*self.free[t], *self.grasps[t], *self.at[t][self.problem.n_agents :]),
            (*self.free[other], *self.grasps[other], *self.at[other][self.problem.n_agents :]),
            strict=True,
        )
        return [pair for first, second in groups for pair in zip(first, second, strict=True)]

    def _other_regions(self) -> list[tuple[int, int]]:
        regions = range(self.problem.n_regions)
        return [(a, b) for a in regions for b in regions if a != b]

    # ---- the loop, capacities and costs

    def _add_loop(self) -> None:
        """The suffix begins at one position, in the state to which the last step leads."""
        model = self.model
        model.add_exactly_one(self.enters)
        model.add_bool_or([self.active[0]])
        for t in range(self.horizon):
            if t:
                model.add_implication(self.active[t], self.active[t - 1])
            model.add_implication(self.enters[t], self.active[t])
            before = self.inside[t - 1] if t else 0
            model.add(self.inside[t] == before + self.enters[t])
            for here, last in self._pairs(t, self.horizon):
                model.add_bool_or([self.enters[t].negated(), here.negated(), last])

    def _add_capacity(self, rule: PublishedFits) -> None:
        """The published counting rule, in integers."""
        numbers = [exact(x) for x in (rule.agent, rule.grasping, rule.object, rule.capacity)]
        unit = 1
        while any((x * unit).denominator != 1 for x in numbers):
            unit *= 10
        agent, grasping, obj, capacity = (int(x * unit) for x in numbers)
        n = self.problem.n_agents
        for t in range(self.horizon + 1):
            for k in range(self.problem.n_regions):
                weight = sum(agent * self.free[t][i][k] + grasping * self.held[t][i][k] for i in range(n))
                weight += sum(obj * self.at[t][n + j][k] for j in range(self.problem.n_objects))
                self.model.add(weight <= capacity)

    def _add_costs(self) -> cp_model.LinearExprT:
        """Each member's way as a flow through regions and positions, so that the linear relaxation is tight."""
        ways, regions = self.problem.integer_ways(), range(self.problem.n_regions)
        terms = []
        for t in range(self.horizon):
            for m, (before, after) in enumerate(zip(self.at[t], self.at[t + 1], strict=True)):
                flow = {(a, b): self.model.new_bool_var("") for a in regions for b in regions}
                for k in regions:
                    self.model.add(sum(flow[k, b] for b in regions) == before[k])
                    self.model.add(sum(flow[a, k] for a in regions) == after[k])
                if m >= self.problem.n_agents:
                    moved = sum(flow[way] for way in self._other_regions())
                    self.model.add(moved == self.carried[t][m - self.problem.n_agents])
                terms += [ways[a][b] * flow[a, b] for a, b in self._other_regions()]
        return cp_model.LinearExpr.sum(terms) if terms else 0
