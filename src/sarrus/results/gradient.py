"""Derivatives of responses and of states with respect to named numbers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..algebra import Array


@dataclass(frozen=True, eq=False)
class Gradient:
    """Values of responses and their derivatives.

    Attributes
    ----------
    responses, names : of the responses and of the numbers
    values : (r,) of the responses
    at : (p,) values of the numbers
    matrix : (r, p) derivatives; not a number for those that do not exist
    """

    responses: tuple[str, ...]
    names: tuple[str, ...]
    values: Array
    at: Array = field(repr=False)
    matrix: Array = field(repr=False)

    @property
    def undefined(self) -> tuple[str, ...]:
        """Numbers without a derivative: alone they contradict equations that others imply, or a root is at zero."""
        missing = np.isnan(self.matrix).any(axis=0)
        return tuple(self.names[k] for k in np.flatnonzero(missing))

    def __getitem__(self, name: str) -> float | Array:
        """The derivative with respect to a number, ``g["spring.k"]``; of several responses, an array (r,).

        Raises
        ------
        KeyError
            If it was not asked for.
        """
        if name not in self.names:
            raise KeyError(
                f"no derivative with respect to {name!r}; there are those to {', '.join(self.names[:8])} ..."
            )
        column = self.matrix[:, self.names.index(name)]
        return float(column[0]) if len(column) == 1 else column

    @property
    def value(self) -> float:
        """The value of the first response."""
        return float(self.values[0])

    def influences(self, response: int = 0) -> Array:
        """Change of a response for one hundredth more of each number (p,): nothing where the number is 0."""
        return np.asarray(0.01 * self.matrix[response] * self.at)

    def ranked(self, response: int = 0) -> list[str]:
        """Names of the numbers by falling influence; those that are 0 at the end, by falling derivative.

        Those without a derivative are left out.
        """
        keys = -abs(self.matrix[response]), -abs(self.influences(response))
        undefined = self.undefined
        return [self.names[k] for k in np.lexsort(keys) if self.names[k] not in undefined]

    def table(self, response: int = 0, most: int = 20) -> str:
        """The numbers of the largest influence as a text."""
        from importlib import import_module

        return str(import_module("sarrus.views").gradient_table(self, response, most))

    def __str__(self) -> str:
        return "\n\n".join(self.table(response) for response in range(len(self.responses)))

    def plot(self, ax: Any = None, response: int = 0, most: int = 15) -> Any:
        """Draw the largest influences as bars; see `sarrus.views.plot_gradient`."""
        from importlib import import_module

        return import_module("sarrus.views").plot_gradient(self, ax, response, most)


@dataclass(frozen=True, eq=False)
class StateDerivatives:
    """Derivatives of all states with respect to named numbers, at the nodes of a run.

    Attributes
    ----------
    names : of the numbers
    t : (n,) [s]
    q_b, v_b, a_b : (n, nq, p)
    lam_b : (n, m, p)
    """

    names: tuple[str, ...]
    t: Array = field(repr=False)
    q_b: Array = field(repr=False)
    v_b: Array = field(repr=False)
    a_b: Array = field(repr=False)
    lam_b: Array = field(repr=False)


@dataclass(frozen=True, eq=False)
class Hessian:
    """Second derivatives of one response with respect to named numbers.

    Attributes
    ----------
    response : its name
    names : of the numbers
    matrix : (p, p), symmetric to round-off
    """

    response: str
    names: tuple[str, ...]
    matrix: Array = field(repr=False)

    def __getitem__(self, pair: tuple[str, str]) -> float:
        """One entry, ``H["spring.k", "rod.mass"]``.

        Raises
        ------
        KeyError
            If it was not asked for.
        """
        if isinstance(pair, str):
            raise KeyError(f'two names are needed, H["{pair}", "{pair}"]')
        for name in pair:
            if name not in self.names:
                told = f"no second derivatives with respect to {name!r}"
                raise KeyError(f"{told}; there are those to {', '.join(self.names[:8])} ...")
        row, column = (self.names.index(name) for name in pair)
        return float(self.matrix[row, column])

    def __str__(self) -> str:
        width = max(12, *map(len, self.names)) + 2
        head = " " * width + "".join(f"{name:>{width}}" for name in self.names)
        rows = zip(self.names, self.matrix, strict=True)
        lines = [f"{name:<{width}}" + "".join(f"{x:>{width}.6g}" for x in row) for name, row in rows]
        return "\n".join([f"second derivatives of {self.response}", head, *lines])

    @property
    def asymmetry(self) -> float:
        """Largest difference of two entries that are equal, relative to the largest entry."""
        largest = abs(self.matrix).max(initial=0.0)
        return float(abs(self.matrix - self.matrix.T).max(initial=0.0) / largest) if largest else 0.0
