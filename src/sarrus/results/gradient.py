"""Derivatives of responses and of states with respect to named numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..algebra import Array
from ..console import printable
from ..deferred import renderer
from ..model.checks.arguments import refuse_place
from ..model.deprecated import with_former_names
from ..model.errors import listed
from ..outputs.output import labelled
from ..outputs.units import quotient, size_in_tables
from .error_estimate import ErrorEstimate
from .motion.trajectory import place_of
from .result import Result

MOVED = 1e-3  # [m] by which a hardpoint is moved for its influence


def _places(name: str, names: Sequence[str], what: str) -> int | list[int]:
    """Return the index of a parameter, or the indices of a vector."""
    if name in names:
        return names.index(name)
    found = [k for k, own in enumerate(names) if own.startswith(f"{name}.")]
    if not found:
        raise KeyError(f"There is no {what} with respect to {name!r}. Choose from {listed([*names])}.")
    return found


def _is_pair(name: object) -> bool:
    """Whether this is a response and a number."""
    return isinstance(name, tuple) and len(name) == 2 and all(isinstance(one, str) for one in name)


@with_former_names
@dataclass(frozen=True, eq=False)
class Gradient(Result):
    """Result of `sensitivity`: responses and their derivatives with respect to parameters.

    Attributes
    ----------
    responses, names : names of the responses and of the parameters
    values : (r,) values of the responses
    at : (p,) values of the parameters
    matrix : (r, p) derivatives; NaN if they do not exist
    errors : of the values of the responses, if requested
    response_units, units : of the responses and of the parameters; empty if not known
    table_units : units in which tables show parameters and derivatives, such as mm; empty for `units`
    """

    responses: tuple[str, ...]
    names: tuple[str, ...]
    values: Array
    at: Array = field(repr=False)
    matrix: Array = field(repr=False)
    errors: tuple[ErrorEstimate, ...] = ()
    response_units: tuple[str, ...] = field(default=(), repr=False)
    units: tuple[str, ...] = field(default=(), repr=False)
    table_units: tuple[str, ...] = field(default=(), repr=False)

    def __post_init__(self) -> None:
        counts = {
            "response_units": len(self.responses),
            "units": len(self.names),
            "table_units": len(self.names),
        }
        for name, count in counts.items():
            if len(getattr(self, name)) != count:
                object.__setattr__(self, name, ("",) * count)

    @property
    def undefined(self) -> tuple[str, ...]:
        """Parameters without a derivative: a change of one alone makes the constraints contradict each other."""
        missing = np.isnan(self.matrix).any(axis=0)
        return tuple(self.names[k] for k in np.flatnonzero(missing))

    def __getitem__(self, name: str | tuple[str, str]) -> float | Array:
        """The derivative with respect to a number, ``g["spring.k"]``, or to a vector's three, ``g["pin.point"]``.

        Of several responses an array with one row for each; ``g["final of slider.x", "spring.k"]`` is that of one.

        Raises
        ------
        KeyError
            If it was not asked for.
        """
        if not isinstance(name, str) and not _is_pair(name):
            raise TypeError(
                f'A gradient must be read by names, got {name!r}. Use g["{self.names[0]}"], of several responses '
                f'g["{self.responses[0]}", "{self.names[0]}"], or the array g.matrix.'
            )
        response, number = (None, name) if isinstance(name, str) else name
        found = self.matrix[:, _places(number, self.names, "derivative")]
        if response is not None:
            if response not in self.responses:
                raise KeyError(f"There is no response {response!r}. Choose from {', '.join(self.responses)}.")
            found = found[self.responses.index(response)]
        elif len(found) == 1:
            found = found[0]
        return found if np.ndim(found) else float(found)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.names)

    def __iter__(self) -> Iterator[str]:
        """The names of the numbers, as of a mapping: ``dict(g)`` has all derivatives."""
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)

    def __contains__(self, name: object) -> bool:
        return name in self.names

    def keys(self) -> tuple[str, ...]:
        """Return the names of the parameters."""
        return self.names

    def items(self) -> Iterator[tuple[str, float | Array]]:
        """Return pairs of names and derivatives."""
        return ((name, self[name]) for name in self.names)

    @property
    def value(self) -> float:
        """The value of the first response."""
        return float(self.values[0])

    def unit(self, name: str, response: int = 0) -> str:
        """The unit of a derivative, ``m²/N``; empty where it is not known.

        Raises
        ------
        KeyError
            If it was not asked for.
        """
        refuse_place("response", response, len(self.responses))
        found = _places(name, self.names, "derivative")
        return quotient(
            self.response_units[response], self.units[found if isinstance(found, int) else found[0]]
        )

    @property
    def increments(self) -> Array:
        """The increase of each parameter by which influences are judged (p,): 1 mm of hardpoints, 1 % of others."""
        return np.where([bool(unit) for unit in self.table_units], MOVED, 0.01 * np.asarray(self.at))

    @property
    def increment(self) -> str:
        """The increments in words, "1 %", "1 mm", or "1 % or 1 mm"."""
        return " or ".join(
            text
            for text, some in (("1 %", not all(self.table_units)), ("1 mm", any(self.table_units)))
            if some
        )

    def influences(self, response: int = 0) -> Array:
        """Return the change of a response if each parameter increases by its increment (p,).

        Coordinates of hardpoints increase by 1 mm, because 1 % of a coordinate depends on the origin; other parameters
        by 1 %, so that the influence of one that is 0 is 0.
        """
        refuse_place("response", response, len(self.responses))
        return np.asarray(self.matrix[response] * self.increments)

    def ranked(self, response: int = 0) -> list[str]:
        """Return the names of the parameters by decreasing influence, then those that are 0, by decreasing derivative.

        Those without a derivative are left out.
        """
        influences = self.influences(response)
        keys = -abs(self.matrix[response]), -abs(influences)
        undefined = self.undefined
        return [self.names[k] for k in np.lexsort(keys) if self.names[k] not in undefined]

    def largest(self, response: int = 0, most: int = 15) -> tuple[list[str], list[float]]:
        """Return names and influences of the most influential parameters, the largest first, without zeros."""
        influences = dict(zip(self.names, self.influences(response).tolist(), strict=True))
        moved = dict(zip(self.names, self.increments, strict=True))
        names = [name for name in self.ranked(response) if moved[name]][:most]
        return names, [influences[name] for name in names]

    def table(self, response: int = 0, most: int = 20) -> str:
        """Return a table of the most influential parameters as text."""
        refuse_place("response", response, len(self.responses))
        return printable(renderer().gradient_table(self, response, most))

    def summary(self) -> str:
        """The result in words."""
        tables = (self.table(response) for response in range(len(self.responses)))
        return "\n\n".join([*tables, *map(str, self.errors)])

    def plot(self, ax: Any = None, response: int | None = None, most: int = 15) -> Any:
        """Draw the largest influences on one response, or on each, as bars; see `sarrus.views.plot_gradient`."""
        return renderer().plot_gradient(self, ax, response, most)


@dataclass(frozen=True, eq=False)
class StateDerivatives(Result):
    """Derivatives of all states with respect to parameters, at the ends of the steps of a run and at its events.

    Attributes
    ----------
    names : of the parameters
    t : (n,) events and corners of forces twice, for the motion before and after them [s]
    q_b, v_b, a_b : (n, nq, p)
    lam_b : (n, m, p)
    coordinates : their names, in the order of q_b
    along : gives the derivatives of any output by its name (n, p)
    units : of the numbers
    """

    names: tuple[str, ...]
    t: Array = field(repr=False)
    q_b: Array = field(repr=False)
    v_b: Array = field(repr=False)
    a_b: Array = field(repr=False)
    lam_b: Array = field(repr=False)
    coordinates: tuple[str, ...] = field(repr=False, default=())
    along: Callable[[str], Array] | None = field(repr=False, default=None)
    units: tuple[str, ...] = field(repr=False, default=())

    def summary(self) -> str:
        """What is differentiated, by what, and when."""
        times = f"at {len(self.t)} times from {self.t[0]:g} to {self.t[-1]:g} s"
        return f"derivatives of coordinates and outputs with respect to {', '.join(self.names)} {times}"

    def output(self, name: str) -> Array:
        """Derivatives of an output by all parameters over time (n, p), ``spring.tension``.

        Raises
        ------
        UnknownOutput
            If there is no such output, which is a KeyError, too.
        """
        if self.along is None or name in self.coordinates:
            return np.asarray(self.q_b[:, place_of(name, self.coordinates, "the run")])
        return self.along(name)

    def __getitem__(self, pair: tuple[str, str]) -> Array:
        """Derivatives of an output by a parameter over time (n,), ``d["slider.x", "spring.k"]``; by a vector (n, 3).

        Raises
        ------
        KeyError
            For an unknown output, and a parameter that was not asked for.
        """
        if not _is_pair(pair):
            raise KeyError(f'An output and a parameter are needed, as in d["slider.x", "{self.names[0]}"].')
        places = _places(pair[1], self.names, "derivative")
        return np.asarray(self.output(pair[0])[:, places])

    def _ipython_key_completions_(self) -> list[tuple[str, str]]:
        return [(one, name) for one in self.coordinates for name in self.names]


@with_former_names
@dataclass(frozen=True, eq=False)
class Hessian(Result):
    """Result of `hessian`: second derivatives of one response with respect to parameters.

    Attributes
    ----------
    response : its name
    names : of the parameters
    matrix : (p, p), symmetric to round-off
    error : of the value of the response, if requested
    response_unit, units : of the response and of the parameters; empty if not known
    table_units : units in which tables show parameters and entries, such as mm; empty for `units`
    """

    response: str
    names: tuple[str, ...]
    matrix: Array = field(repr=False)
    error: ErrorEstimate | None = None
    response_unit: str = field(default="", repr=False)
    units: tuple[str, ...] = field(default=(), repr=False)
    table_units: tuple[str, ...] = field(default=(), repr=False)

    def __getitem__(self, pair: tuple[str, str]) -> float | Array:
        """Return one entry, ``H["spring.k", "rod.mass"]``, or three of a vector, ``H["pin.point", "rod.mass"]``.

        Raises
        ------
        KeyError
            If it was not asked for.
        """
        if isinstance(pair, str):
            raise KeyError(f'Two names are needed, as in H["{pair}", "{pair}"].')
        row, column = (_places(name, self.names, "second derivative") for name in pair)
        found = self.matrix[row][..., column]
        return found if np.ndim(found) else float(found)

    def _ipython_key_completions_(self) -> list[tuple[str, str]]:
        return [(one, other) for one in self.names for other in self.names]

    def unit(self, first: str, second: str) -> str:
        """The unit of an entry, ``m³/N²``; empty where it is not known."""
        places = (_places(name, self.names, "second derivative") for name in (first, second))
        found = [self.units[place if isinstance(place, int) else place[0]] for place in places if self.units]
        return quotient(self.response_unit, *found) if found else ""

    def in_table_units(self) -> tuple[list[str], Array]:
        """The names of the parameters with the units of tables, and the entries in these units (p, p)."""
        none = ("",) * len(self.names)
        pairs = [*zip(self.units or none, self.table_units or none, strict=True)]
        sizes = np.array([size_in_tables(*pair) for pair in pairs])
        names = [labelled(name, own or unit) for name, (unit, own) in zip(self.names, pairs, strict=True)]
        return names, self.matrix * np.outer(sizes, sizes)

    def summary(self) -> str:
        """Return the result as text; the unit of an entry is that of the response over those of row and column."""
        names, matrix = self.in_table_units()
        width = max(12, *map(len, names)) + 2
        head = " " * width + "".join(f"{name:>{width}}" for name in names)
        rows = zip(names, matrix, strict=True)
        lines = [f"{name:<{width}}" + "".join(f"{x:>{width}.6g}" for x in row) for name, row in rows]
        bar = [str(self.error)] if self.error else []
        return "\n".join(
            [f"second derivatives of {labelled(self.response, self.response_unit)}", head, *lines, *bar]
        )

    @property
    def asymmetry(self) -> float:
        """The largest difference of two symmetric entries, relative to the largest entry."""
        largest = abs(self.matrix).max(initial=0.0)
        return float(abs(self.matrix - self.matrix.T).max(initial=0.0) / largest) if largest else 0.0
