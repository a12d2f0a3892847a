"""A motion without inertia: which body lacks mass or inertia along a direction that the constraints leave free."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csr_array

from ...algebra import Array
from ...model import ModelError
from ...system import System
from .length import LEAST_LEVER, extent, lever, units
from .nullspace import NullSpace

LEAST = 1e-14  # of the largest inertia along a free motion: what cannot be distinguished from none
DENSE_UP_TO = 1500  # coordinates, for which free motions are computed


def missing_inertia(system: System, q: Array, t: float, b: Array) -> str | None:
    """A message that names the body, or None where all free motions have inertia."""
    if system.nq > DENSE_UP_TO or not np.all(np.isfinite(q)):
        return None
    J = system.Phi_q(q, t, b=b)
    Z = NullSpace(J, lever(system, q, J)).Z
    return along(system, q, Z, system.M(q, b=b))


def along(system: System, q: Array, Z: Array, M: csr_array) -> str | None:
    """The same, for the motions Z (nq, d) and the mass matrix M.

    Displacements are measured by the largest radius of gyration, so that masses compare with moments of inertia.
    """
    if not Z.shape[1]:
        return None
    largest = M.diagonal()[: system.moving].reshape(-1, 7).max(axis=0)
    gyration = float(np.sqrt(largest[3:].max() / largest[:3].max())) if largest[:3].max() > 0 else 0.0
    unit = units(system.nq, max(gyration, LEAST_LEVER * extent(system, q)))
    motions = unit[:, None] * np.linalg.qr(Z / unit[:, None])[0]
    sizes, shapes = eigh(motions.T @ (M @ motions))
    if sizes[0] > LEAST * sizes[-1]:
        return None
    spins = (motions @ shapes[:, 0])[: system.moving].reshape(-1, 7)[:, 3:]
    return (
        f"body {list(system.bodies)[int(np.argmax((spins**2).sum(axis=1)))]}: it has no inertia along a motion that "
        "its joints allow, or less than 1e-14 of the largest in the model. Give it mass and inertia about all axes."
    )


def refuse_missing_inertia(system: System, q: Array, Z: Array, M: csr_array) -> None:
    """Refuse a system whose accelerations along Z are not determined.

    Raises
    ------
    ModelError
    """
    message = along(system, q, Z, M)
    if message is not None:
        raise ModelError(f"{system.name}: {message}")
