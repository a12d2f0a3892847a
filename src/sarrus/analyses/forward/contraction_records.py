"""Records of kernels and arrays for contracted second derivatives of forward dynamics, see `contraction_loop`."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csc_array

from ..._jit.kernels.pointer import NONE
from ..._jit.kernels.vector import LANES
from ...algebra import Array
from ...system import System
from ...system.curves.lane_buffers import buffer
from ..sensitivity.lagrangians.changes import lagrangian
from . import contraction_loop as loop


def columns_of(changes: Array) -> loop.Columns:
    """The combinations of parameters that are the columns of changes (len(b), k)."""
    every = csc_array(changes)
    return loop.Columns(every.indptr.astype(np.int64), every.indices.astype(np.int64), every.data)


def equations_of(of: Any, kinds: tuple[str, ...] = ("motion", "rate", "place")) -> loop.Equations:
    """The equations of a system, or coordinates of joints, which have their structure."""
    kernels = [lagrangian(of, kind) for kind in kinds] + [NONE] * (3 - len(kinds))
    rows = [buffer(of.m) for _ in range(6)]
    return loop.Equations._make([*kernels, of.b.copy(), np.zeros(len(of.b)), *rows, buffer(len(of.b))])


def state_of(system: System) -> loop.State:
    """Arrays for a state and its changes."""
    return loop.State._make([np.zeros(LANES), *(buffer(system.nq) for _ in range(11))])
