"""Records of kernels and arrays for contracted second derivatives of forward dynamics, see `contraction_loop`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csc_array

from ..._jit.kernels.pointer import NONE
from ..._jit.kernels.vector import LANES
from ...algebra import Array
from ...system import System
from ...system.curves.lane_buffers import buffer
from ..equilibria.independent_coordinates import Independent
from ..equilibria.motion_at import input_changes
from ..sensitivity.lagrangians.changes import lagrangian
from . import contraction_loop as loop
from .parameter_changes import ParameterChanges


def columns_of(changes: Array) -> loop.Columns:
    """The combinations of parameters that are the columns of changes (len(b), k)."""
    every = csc_array(changes)
    return loop.Columns(every.indptr.astype(np.int64), every.indices.astype(np.int64), every.data)


class CurvedParameters(NamedTuple):
    """Inputs and parameters as combinations, and second derivatives of b and c behind them, as more combinations.

    Attributes
    ----------
    b, c : (len(b), nu + p + n), (len(measured.b), nu + p + n) changes of the elements' and the coordinates' parameters
    by_b, by_c : those of inputs and parameters, for compiled code
    curved : to which entries of H the others belong
    """

    b: Array
    c: Array
    by_b: loop.Columns
    by_c: loop.Columns
    curved: loop.Curved

    @classmethod
    def of(
        cls,
        system: System,
        inputs: Sequence[str],
        parameters: ParameterChanges,
        first: int,
        independent: Independent | None = None,
    ) -> CurvedParameters:
        """Those of inputs and parameters, which have rows of H from the first on.

        Raises
        ------
        SarrusError
            For parameters of tables and formulas, and coordinates that no joint has.
        """
        bent, pairs = parameters.second(system)
        for one in (parameters, bent):
            one.refuse_curves(system, "Leave it out.")
        of_c = [np.zeros((0, one.b.shape[1])) for one in (parameters, bent)]
        if independent is not None:
            of_c = [one.of_coordinates(system, independent) for one in (parameters, bent)]
        b = np.hstack([input_changes(system, inputs), parameters.b, bent.b])
        c = np.hstack([np.zeros((len(of_c[0]), len(inputs))), *of_c])
        count = len(inputs) + len(parameters.names)
        by = columns_of(b[:, :count]), columns_of(c[:, :count])
        return cls(b, c, *by, loop.Curved(*(pairs + first + len(inputs))))


def equations_of(of: Any, kinds: tuple[str, ...] = ("motion", "rate", "place")) -> loop.Equations:
    """The equations of a system, or coordinates of joints, which have their structure."""
    kernels = [lagrangian(of, kind) for kind in kinds] + [NONE] * (3 - len(kinds))
    rows = [buffer(of.m) for _ in range(6)]
    return loop.Equations._make([*kernels, of.b.copy(), np.zeros(len(of.b)), *rows, buffer(len(of.b))])


def state_of(system: System) -> loop.State:
    """Arrays for a state and its changes."""
    return loop.State._make([np.zeros(LANES), *(buffer(system.nq) for _ in range(11))])
