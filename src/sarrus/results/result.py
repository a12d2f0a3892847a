"""Base classes of results: warnings, which are printed with each result."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np

from ..algebra import Array
from ..console import printable
from ..model.read_only import read_only
from ..rendering import Display


@dataclass(frozen=True, eq=False)
class Result(Display):
    """Base of the results of analyses.

    Attributes
    ----------
    warnings : short messages about what may not be as the user expects; Python has issued them, too
    call : of the analysis, by which `verify` repeats it; a copy in another process has none
    """

    warnings: tuple[str, ...] = field(default=(), kw_only=True, repr=False)
    call: Any = field(default=None, kw_only=True, repr=False, compare=False)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "call": None}  # functions of the user among its arguments cannot be stored

    def changed(self, **fields: Any) -> Self:
        """A copy with other fields; those that are not computed yet stay so."""
        found = object.__new__(type(self))
        found.__dict__.update(self.__dict__, **fields)
        return found

    def summary(self) -> str:
        """The result in words, without its warnings; by default its kind."""
        return type(self).__name__

    def headline(self) -> str:
        """The first line of the summary."""
        return self.summary().partition("\n")[0].rstrip(".:")

    def __str__(self) -> str:
        return printable("\n".join([self.summary(), *(f"warning: {message}" for message in self.warnings)]))


class NoStates(np.ndarray[Any, np.dtype[np.float64]]):
    """An array without entries, of a failed analysis: what indexes it receives the failure."""

    failure = ""

    def __array_finalize__(self, other: Any) -> None:
        self.failure = getattr(other, "failure", "")

    @classmethod
    def of(cls, array: Any, failure: str) -> NoStates:
        """The array as one that names a failure."""
        found = np.asarray(array).view(cls)
        found.failure = failure
        return found

    def __getitem__(self, key: Any) -> Any:
        try:
            return super().__getitem__(key)
        except IndexError:
            raise IndexError(self.failure) from None


def values_of(run: Any, array: Array) -> Array:
    """Values over the times of a run, to be read only; those of a failed one without states name the failure."""
    if len(run.t) or run.success:
        found: Array = read_only(array)
        return found
    why = run.message.removesuffix(".")
    return NoStates.of(array, f"{run.name}: there are no states, because the analysis failed. {why}.")


class WarningSequence:
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


class ResultList(WarningSequence, list[Any]):
    """Results in a list."""


class Product(WarningSequence, np.ndarray[Any, np.dtype[np.float64]]):
    """An array; what is computed from it is a plain one."""

    @classmethod
    def of(cls, array: Array) -> Product:
        """The array as one that carries warnings."""
        return np.asarray(array).view(cls)

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        plain = np.asarray(array)
        return plain[()] if return_scalar else plain
