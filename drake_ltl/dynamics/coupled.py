"""Dynamics of an object (2b), and of an object with the team that holds it (7)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import null_space

from drake_ltl.dynamics.control_laws import body_gravity
from drake_ltl.dynamics.grasp import object_to_agent_jacobian, object_to_agent_jacobian_rate, skew
from drake_ltl.dynamics.spatial import SpatialDynamics


def object_dynamics(mass: float, I_OOo_O: np.ndarray, R_WO: np.ndarray, w_WO: np.ndarray) -> SpatialDynamics:
    """M_O, C_O, g_O of (2b), for an object whose origin Oo is its centre of mass.

    C_O v = (omega x I omega; 0) is Euler's term; of the matrices that yield it S(omega) I is the one for which
    dM_O/dt - 2 C_O = -(S I + I S) is skew symmetric.

    Args:
        mass: [kg].
        I_OOo_O: rotational inertia about Oo (3, 3) [kg m^2].
        R_WO: orientation (3, 3).
        w_WO: angular velocity (3,) [rad/s].
    """
    I_W = R_WO @ I_OOo_O @ R_WO.T
    M, C = mass * np.eye(6), np.zeros((6, 6))
    M[:3, :3] = I_W
    C[:3, :3] = skew(w_WO) @ I_W
    return SpatialDynamics(M, C, body_gravity(mass))


def coupled_dynamics(
    body: SpatialDynamics, team: Sequence[SpatialDynamics], offsets: Sequence[np.ndarray], w_WO: np.ndarray
) -> SpatialDynamics:
    """M~, C~, g~ of (7): M~ vdot_O + C~ v_O + g~ = G^T u, sums over the team instead of one stacked product.

    M~ = M_O + G^T M_T G, C~ = C_O + G^T (M_T dG/dt + C_T G), g~ = g_O + G^T g_T. M~ is symmetric and positive
    definite and dM~/dt - 2 C~ skew symmetric (Lemma 1). If an arm has fewer than six joints, (7) holds for the
    `admissible_twists` E: E^T (M~ vdot_O + C~ v_O + g~ - G^T u) = 0. If one has more and moves in its null space,
    its `null_space_wrench` belongs to the left-hand side.

    Args:
        body: (2b) of the object.
        team: (1b) of each member.
        offsets: p_OoEo_W (3,) [m] of each member.
        w_WO: the object's angular velocity (3,) [rad/s].
    """
    M, C, g = body.M.copy(), body.C.copy(), body.g.copy()
    for agent, p in zip(team, offsets, strict=True):
        J_O, J_O_dot = object_to_agent_jacobian(p), object_to_agent_jacobian_rate(p, w_WO)
        M += J_O.T @ agent.M @ J_O
        C += J_O.T @ (agent.M @ J_O_dot + agent.C @ J_O)
        g += J_O.T @ agent.g
    return SpatialDynamics(M, C, g)


def admissible_twists(
    jacobians: Sequence[np.ndarray], offsets: Sequence[np.ndarray], tolerance: float = 1e-6
) -> np.ndarray:
    """E (6, d), orthonormal columns: the twists of the object that all arms can follow; all six if each has six joints.

    Args:
        jacobians: J_i (6, n_i) of each member.
        offsets: p_OoEo_W (3,) [m] of each member.
        tolerance: a twist that an arm misses by less, per unit of twist, counts as followed: headings and grasps
            are not exact.
    """
    missed = [
        (np.eye(6) - J @ np.linalg.pinv(J)) @ object_to_agent_jacobian(p)
        for J, p in zip(jacobians, offsets, strict=True)
        if J.shape[1] < 6
    ]
    if not missed:
        return np.eye(6)
    stacked = np.concatenate(missed)
    return null_space(stacked, rcond=tolerance / max(float(np.linalg.norm(stacked, 2)), tolerance))
