"""Records of kernels and sparse matrices for the compiled linearization, see `linear_loop`."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..._jit.kernels.pointer import NONE
from ...system import System
from ..dynamics.stepping.entries import entry_of
from . import linear_loop as loop

KINEMATIC = "Phi_q", "Phi_qT_lam_q", "Phi_q_xi_q", "gamma_q", "gamma_v"


def sparse(system: Any, name: str) -> loop.Sparse:
    """The pattern of an operator, and memory for its numbers."""
    pattern = system.pattern(name)
    first, columns = (x.astype(np.int64) for x in (pattern.indptr, pattern.indices))
    return loop.Sparse(first, columns, np.zeros(pattern.size))


def constraints(of: Any) -> loop.Constraints:
    """The constraints of a system, or coordinates of joints, which have their structure."""
    second = sparse(of, "Phi_q_xi_q")
    kernels = (entry_of(of, *KINEMATIC), entry_of(of, "Phi_q_xi_q")) if of.m else (NONE, NONE)
    numbers = [*(sparse(of, name) for name in KINEMATIC), second]
    return loop.Constraints._make([*kernels, of.b, np.zeros(of.m), *numbers])


def forces(system: System) -> loop.Forces:
    """Forces and inertia of a system."""
    groups = ("Q_q", "Q_v"), ("M_a_q",), ("S_q",), ("S_v",)
    names = [name for group in groups for name in group]
    kernels = (entry_of(system, *group) for group in groups)
    return loop.Forces._make([*kernels, *(sparse(system, name) for name in names)])
