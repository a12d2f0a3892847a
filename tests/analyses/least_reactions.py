"""Multipliers of least norm of the joints' forces and moments, by dense algebra from rigid motions of the bodies."""

import numpy as np

import sarrus as sr
from sarrus.euler import A, E


def supports(system: sr.System) -> list[tuple[np.ndarray, str, np.ndarray]]:
    """The equations of each joint or driver, a moving body, and the joint's point on it."""
    found = []
    turned = {
        d.name for d in system.model.drivers if not isinstance(d, sr.DisplacementDriver)
    }  # without a point
    for name, rows in system.rows.items():
        m = system.marker(name)
        found += [
            (rows, body, s)
            for body, s in ((m.body_i, m.s_i), (m.body_j, m.s_j))
            if body in system.bodies and name not in turned
        ]
    return found


def wrenches(system: sr.System, q: np.ndarray, t: float) -> np.ndarray:
    """Forces times the length, and moments, of unit multipliers, on all bodies that a joint moves."""
    every, J = supports(system), system.Phi_q(q, t).toarray()
    length = np.sqrt(np.mean([s @ s for _, _, s in every]))
    count = [sum(rows is other for other, _, _ in every) for rows, _, _ in every]
    found = []
    for (rows, body, s), n in zip(every, count, strict=True):
        at, motions = system.coordinates_of(body), np.zeros((7, 6))
        motions[:3, :3] = np.eye(3) * length
        for k, omega in enumerate(np.eye(3)):
            motions[:3, 3 + k] = np.cross(omega, -A(q[at][3:]) @ s)
            motions[3:, 3 + k] = 0.5 * E(q[at][3:]).T @ omega
        block = np.zeros((6, system.m))
        block[:, rows] = (J[rows, at] @ motions).T / np.sqrt(n)
        found.append(block)
    return np.concatenate(found)


def least(system: sr.System, q: np.ndarray, force: np.ndarray, t: float = 0.0) -> np.ndarray:
    """The multipliers with these constraint forces Φ_qᵀλ."""
    J, W = system.Phi_q(q, t).toarray(), wrenches(system, q, t)
    lam = np.linalg.lstsq(J.T, force, rcond=1e-9)[0]
    left, sizes, _ = np.linalg.svd(J / np.linalg.norm(J, axis=1)[:, None])
    null = left[:, np.sum(sizes > 1e-9 * sizes[0]) :] / np.linalg.norm(J, axis=1)[:, None]
    return np.asarray(lam - null @ np.linalg.lstsq(W @ null, W @ lam, rcond=1e-12)[0])
