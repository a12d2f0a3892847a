"""Results that are a tuple, a list or an array, and carry warnings besides."""

from __future__ import annotations

from copy import copy
from typing import Any, Self

import numpy as np

from ..algebra import Array
from .singularity import Singularity


class Warned:
    """A sequence that carries warnings.

    Attributes
    ----------
    warnings : see `Result`
    """

    warnings: tuple[str, ...] = ()

    def with_warnings(self, warnings: tuple[str, ...]) -> Self:
        """The same with warnings."""
        found = copy(self)
        found.warnings = warnings
        return found


class Singularities(Warned, tuple[Singularity, ...]):
    """Singular configurations in the order of a path."""


class ResultList(Warned, list[Any]):
    """Results in a list."""


class Product(Warned, np.ndarray[Any, np.dtype[np.float64]]):
    """An array; what is computed from it is a plain one."""

    @classmethod
    def of(cls, array: Array) -> Product:
        """The array as one that carries warnings."""
        return np.asarray(array).view(cls)

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        plain = np.asarray(array)
        return plain[()] if return_scalar else plain
