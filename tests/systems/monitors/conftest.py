"""Case ii in any step, with everybody anywhere, as monitors see it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import pytest
from drake_ltl.diagrams import MakeMissionDiagram

from drake_ltl.systems.program import Weld
from drake_ltl.systems.progress import AgentSignals, Progress
from drake_ltl.systems.signals import NO_GRASP, Mode, Phase, pack_reach


@pytest.fixture(scope="module")
def diagram(mission, case_ii, models):
    return MakeMissionDiagram(mission, case_ii, models, num_steps=9)


OF_SPHERES = ("clearance", "forbidden_region", "workspace", "region")


@dataclass
class Stage:
    """A root context, and looks of monitors at it."""

    diagram: object
    root: object

    def look(self, name: str) -> list[str]:
        """What a monitor, or one of its rules, sees that is new, as lines."""
        return [str(seen) for seen in self.found(name)]

    def found(self, name: str) -> tuple:
        monitor = self.diagram.monitors["spheres" if name in OF_SPHERES else name]
        new = monitor.Look(monitor.GetMyContextFromRoot(self.root))
        return tuple(seen for seen in new if name in (monitor.kind, seen.monitor))

    def put(self, world) -> None:
        """Bodies."""
        parts = self.diagram.transport_plant
        context = parts.plant.GetMyMutableContextFromRoot(self.root)
        for name, instance in (parts.agents | parts.objects).items():
            parts.plant.SetPositionsAndVelocities(context, instance, world.state(name))

    def tell(self, progress: Progress) -> None:
        """The supervisor's state."""
        supervisor = self.diagram.supervisor
        supervisor.SetProgress(supervisor.GetMyMutableContextFromRoot(self.root), progress)


@pytest.fixture
def stage(diagram) -> Stage:
    """With everybody at the start, whatever that is good for."""
    return Stage(diagram, diagram.CreateStartContext())


@pytest.fixture
def begin(mission, program, world_at) -> Callable[..., tuple]:
    """begin(number, **changes of Progress): everybody's places as the step begins, and its Progress."""

    def make(number: int, phase: Phase = Phase.NAVIGATE, **changes) -> tuple:
        layout = mission.steps[program.index(number)].before
        world = world_at(layout)
        agents = []
        for name, q in world.q.items():
            held = layout.agents[name].grasp
            grasp = NO_GRASP if held is None else program.welds.index(Weld(name, *held))
            agents.append(AgentSignals(Mode.HOLD, q, pack_reach(0.0, 1.0, q, q), grasp))
        return world, Progress(number, phase, 0.0, 0, world.anchor, tuple(agents), **changes)

    return make
