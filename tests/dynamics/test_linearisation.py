"""An agent's closed loop under (10a) about its goal, linearised through the converted controller."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import AffineSystem, Linearize

from drake_ltl.navigation import NavigationFunction, RegionBall, StaticBody, Traveller, step_relations
from drake_ltl.systems.transition_controller import TransitionController

FORCE, DELTA = 40.0, 0.5  # k [N], and the pseudo-Huber's radius [m]: the stiffness at the goal is k / delta
DAMPING = np.array([18.0, 18.0, 3.0, 3.0])
Q_GOAL = np.array([1.5, -0.5, 0.9, 0.5])


@pytest.fixture(scope="module")
def model(models):
    return models.agents["a2"]


def gradient(model, q: np.ndarray) -> np.ndarray:
    """k dPhi/dq (4,) for one traveller with another body 3 m beside its goal."""
    goal = tuple(model.centre(Q_GOAL))
    beside = StaticBody("a1", 1.25, (goal[0] + 3.0, goal[1], goal[2]))
    relations = step_relations(
        travellers=[Traveller("a2", 1.25, "here", "there", (0.0, 0.0, 0.2), goal)],
        static_agents=[beside],
        regions=[RegionBall("here", (0.0, 0.0, 0.0), 20.0), RegionBall("there", goal, 2.0)],
        workspace_radius=30.0,
    )
    phi = NavigationFunction.for_goal(relations.relations, relations.goal, kappa=12.0)
    weights, error = model.gamma_weights, q - Q_GOAL
    _, by_gamma, by_p = phi.value_and_gradient(error @ (weights * error), relations.at(model.centre(q)[None]))
    return FORCE * (2.0 * by_gamma * weights * error + by_p[0] @ model.centre_jacobian(q))


@pytest.fixture(scope="module")
def hessian(model) -> np.ndarray:
    """Of k Phi at the goal (4, 4), by central differences of its gradient."""
    h = 1e-5
    return np.stack(
        [(gradient(model, Q_GOAL + h * e) - gradient(model, Q_GOAL - h * e)) / (2.0 * h) for e in np.eye(4)]
    )


@pytest.fixture(scope="module")
def loop(model, arm_plant, hessian):
    """Plant, controller and the navigation function's slope about the goal, as one diagram at rest at the goal."""
    builder = DiagramBuilder()
    plant = arm_plant(model.agent.heading, builder)
    controller = builder.AddSystem(TransitionController(model, DAMPING, speed_limit=2.0))
    n = model.n
    slope = builder.AddSystem(
        AffineSystem(
            A=np.zeros((0, 0)),
            B=np.zeros((0, 2 * n)),
            f0=np.zeros(0),
            C=np.zeros((n, 0)),
            D=np.hstack([hessian, np.zeros((n, n))]),
            y0=-hessian @ Q_GOAL,
        )
    )
    builder.Connect(plant.get_state_output_port(), slope.get_input_port())
    builder.Connect(plant.get_state_output_port(), controller.get_state_input_port())
    builder.Connect(slope.get_output_port(), controller.get_gradient_input_port())
    builder.Connect(controller.get_torque_output_port(), plant.get_actuation_input_port())
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    context.SetContinuousState(np.concatenate([Q_GOAL, np.zeros(n)]))
    return SimpleNamespace(diagram=diagram, context=context, plant=plant)


def test_the_potential_is_quadratic_at_the_goal(model, hessian):
    """Its stiffness there is k / delta, whatever obstacles are about: Phi = gamma / (2 delta) to second order."""
    np.testing.assert_allclose(hessian, hessian.T, atol=1e-6)
    np.testing.assert_allclose(hessian, FORCE / DELTA * np.diag(model.gamma_weights), atol=1e-3)  # third order times h


def test_the_goal_is_an_equilibrium(loop):
    rates = loop.diagram.EvalTimeDerivatives(loop.context).CopyToVector()
    np.testing.assert_allclose(rates, 0.0, atol=1e-9)


def test_the_goal_is_asymptotically_stable(loop):
    eigenvalues = np.linalg.eigvals(Linearize(loop.diagram, loop.context).A())
    assert eigenvalues.real.max() < -0.5  # [1/s]; no mode is slower than two seconds


def test_linearisation_is_that_of_the_law(loop, model, hessian):
    """(10a) cancels gravity: B delta qdd = -H delta q - K delta qd, in which N qd is of second order."""
    n = model.n
    B = model.inertia(Q_GOAL)
    below = -np.linalg.solve(B, np.hstack([hessian, np.diag(DAMPING)]))
    expected = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), below])
    np.testing.assert_allclose(Linearize(loop.diagram, loop.context).A(), expected, atol=1e-9)


def test_linearisation_is_that_of_finite_differences(loop):
    """Of the closed loop of doubles: nothing here knows of AutoDiff or of the law."""
    x, h = loop.context.get_continuous_state_vector().CopyToVector(), 1e-6
    context = loop.diagram.CreateDefaultContext()

    def rates(state: np.ndarray) -> np.ndarray:
        context.SetContinuousState(state)
        return loop.diagram.EvalTimeDerivatives(context).CopyToVector()

    differences = np.stack([(rates(x + h * e) - rates(x - h * e)) / (2.0 * h) for e in np.eye(len(x))], axis=1)
    A = Linearize(loop.diagram, loop.context).A()
    np.testing.assert_allclose(A, differences, atol=1e-6 * np.abs(A).max())  # h^2, and rounding over h
    ours, theirs = (np.sort_complex(np.linalg.eigvals(matrix)) for matrix in (A, differences))
    np.testing.assert_allclose(ours, theirs, atol=1e-4)


def test_motion_beyond_the_speed_limit_can_be_linearised_too(loop):
    """Where damping grows with the speed, derivatives of the growth count as well."""
    context = loop.diagram.CreateDefaultContext()
    x, h = np.concatenate([Q_GOAL + 0.1, [2.5, 1.0, 0.2, -0.1]]), 1e-6
    context.SetContinuousState(x)
    A = Linearize(loop.diagram, context, equilibrium_check_tolerance=np.inf).A()

    def rates(state: np.ndarray) -> np.ndarray:
        context.SetContinuousState(state)
        return loop.diagram.EvalTimeDerivatives(context).CopyToVector()

    differences = np.stack([(rates(x + h * e) - rates(x - h * e)) / (2.0 * h) for e in np.eye(len(x))], axis=1)
    np.testing.assert_allclose(A, differences, atol=1e-6 * np.abs(A).max())
