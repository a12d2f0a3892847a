"""Compiled functions whose `data` may be used as long as it exists, whatever becomes of the object that made it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..._jit.kernels.bound import Bound
from ...algebra import Array
from ...system import System


class Addresses(np.ndarray):
    """The `data` of a compiled function. It and its copies own the arrays at these addresses."""

    owned: Any = None

    def __array_finalize__(self, source: Any) -> None:
        self.owned = getattr(source, "owned", None)


class LastingFunction(Bound):
    """A compiled function with fixed arguments, see `Bound`, of the kernels of a system; `data` owns them.

    Attributes
    ----------
    fast : data without this, which numpy and Numba take faster
    """

    def __init__(self, system: System, function: Callable[..., Any], *fixed: Any) -> None:
        super().__init__(function, *fixed)
        self.fast: Array = self.data
        owner = Addresses(self.fast.shape, self.fast.dtype)  # with memory of its own: views refer to it
        owner[:], owner.owned = self.fast, (system, fixed)
        self.data = owner


class ForCompiledCode:
    """Base class of functions that other compiled code calls by `function` and `data`, after the first call."""

    def _bound(self) -> LastingFunction:
        """The function with its fixed arguments.

        Raises
        ------
        SarrusError
            Before the first state.
        """
        raise NotImplementedError

    @property
    def function(self) -> Any:
        """The compiled function."""
        return self._bound().function

    @property
    def data(self) -> Array:
        """The first argument of the compiled function."""
        return self._bound().data
