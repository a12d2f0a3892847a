"""Base classes of results: warnings, which are printed with each result."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np

from ..algebra import Array
from ..console import printable
from ..rendering import Shown


@dataclass(frozen=True, eq=False)
class Result(Shown):
    """Base of the results of analyses.

    Attributes
    ----------
    warnings : short messages about what may not be as the user expects; Python has issued them, too
    """

    warnings: tuple[str, ...] = field(default=(), kw_only=True, repr=False)

    def summary(self) -> str:
        """The result in words, without its warnings; by default its kind."""
        return type(self).__name__

    def headline(self) -> str:
        """The first line of the summary."""
        return self.summary().partition("\n")[0].rstrip(".:")

    def __str__(self) -> str:
        return printable("\n".join([self.summary(), *(f"warning: {message}" for message in self.warnings)]))


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
