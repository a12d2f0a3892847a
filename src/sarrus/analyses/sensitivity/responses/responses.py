"""Responses: numbers that a motion has, each made of an output over time in one way; with exact derivatives.

An output is given by its name, or as a function of `Outputs` that computes its value alone.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import count
from typing import Any, TypeAlias

import numpy as np

from ....algebra import Array
from ....model.checks.arguments import CHECKS, in_seconds
from ....model.checks.calls import CallCheck
from ....model.registry import described
from ....model.tape import Tracer
from ....outputs import Outputs, UnknownOutput, find_output
from ....outputs.units import product
from ....system import System
from .extremes import Vertex, top_of
from .panels import Layout

Output: TypeAlias = str | Callable[[Any], Any]


@dataclass(frozen=True, eq=False)
class Response(metaclass=CallCheck):
    """Base class of responses.

    Parameters
    ----------
    of : name of an output, a formula of outputs, or a function of `Outputs`
    name : name in results; by default made from the output's name
    layout : for internal use: where kinks are among the samples of a response over the whole run
    reported : for internal use: kinds of states that are taken as the run reports them, if one of them is needed
    """

    of: Output
    name: str = ""
    layout: Layout = field(default=Layout(), repr=False, kw_only=True)
    reported: Collection[str] = field(default=(), repr=False, kw_only=True)

    def __init_subclass__(cls) -> None:
        cls.__doc__ = described(cls)

    def __post_init__(self) -> None:
        if not isinstance(self.of, str) and (isinstance(self.of, type) or not callable(self.of)):
            raise TypeError(
                f"an output is a name, such as 'slider.x', or a function of Outputs, but is {self.of!r}. "
                "Give one of them."
            )
        given: Any = self.name
        if not isinstance(given, str):
            message = f"{type(self).__name__} of {self.output_label}: name must be a text, got {given!r}"
            raise TypeError(
                f"{message}. Name the arguments after the output, as in At('slider.x', time=0.5)."
            )

    @property
    def title(self) -> str:
        """The name in tables."""
        return self.name or f"{type(self).__name__.lower()} of {self.output_label}"

    @property
    def pointwise(self) -> bool:
        """Whether it is of the output at single times, not of its whole history."""
        return True

    @property
    def additive(self) -> bool:
        """Whether it is a sum over its times or steps, each of which may be evaluated apart."""
        return False

    def part(self, rows: Array) -> Response:
        """Return the response at some of its times, if it is additive (nt,)."""
        return self

    @property
    def output_label(self) -> str:
        """The label of its output."""
        name = self.of if isinstance(self.of, str) else getattr(self.of, "__name__", "response")
        return name.strip("<>")

    def unit(self, system: System) -> str:
        """The unit of its value; empty for a function of `Outputs`, unless it has a method ``unit(system)``."""
        if isinstance(self.of, str):
            return find_output(system, self.of).unit
        found: str = self.of.unit(system) if hasattr(self.of, "unit") else ""
        return found

    def times(self, t: Array) -> Array | None:
        """Return the times at which the output is needed; None for all nodes."""
        return None

    def value(self, g: Array, t: Array) -> float:
        """Return the response from the output at its times."""
        raise NotImplementedError

    def weights(self, g: Array, t: Array) -> Array:
        """Return the derivatives of the response with respect to the output at each time."""
        raise NotImplementedError

    def weights_along(self, g: Array, t: Array, g_dot: Array, t_dot: Array) -> Array:
        """Return the change of the weights with the output and the times."""
        return np.zeros_like(g)

    def vanishing_weights(self, g: Array, t: Array, weights: Array) -> Array:
        """Return which weights are zero only at this output (nt,), as those of residuals that vanish."""
        none = (weights == 0.0).astype(float)
        return np.asarray(none * self.weights_along(g, t, none, np.zeros(len(t))) != 0.0)

    def by_times(self, g: Array, t: Array) -> Array:
        """Return the derivatives with respect to the times, which events change."""
        return np.zeros_like(g)

    def by_times_along(self, g: Array, t: Array, g_dot: Array, t_dot: Array) -> Array:
        """Return the change of the weights with the output and the times."""
        return np.zeros_like(g)

    def evaluate(self, outputs: Outputs) -> Tracer:
        """The output, recorded.

        Raises
        ------
        TypeError
            For a function that returns something else than one number for each time.
        """
        found = outputs(self.of) if isinstance(self.of, str) else self.of(outputs)
        if isinstance(found, Tracer):
            return found
        if np.asarray(found).dtype.kind not in "biuf" or np.size(found) not in (1, np.size(outputs.t.value)):
            message = f"{np.size(found)} numbers" if np.ndim(found) else repr(found)
            raise TypeError(f"{self.title}: the function returns {message}. Return one number.")
        return outputs.constant(np.asarray(found, dtype=float))


class OneValue:
    """The value and the weights of a response that is an output at one time."""

    @property
    def additive(self) -> bool:
        return True

    def value(self, g: Array, t: Array) -> float:
        return float(g[0])

    def weights(self, g: Array, t: Array) -> Array:
        return np.ones(1)


@dataclass(frozen=True, eq=False)
class Final(OneValue, Response):
    """Response: an output at the end of the run."""

    def times(self, t: Array) -> Array | None:
        return t[-1:]


@dataclass(frozen=True, eq=False)
class Initial(Final):
    """Response: an output at the start of the run."""

    def times(self, t: Array) -> Array | None:
        return t[:1]


@dataclass(frozen=True, eq=False)
class At(OneValue, Response):
    """Response: an output at a given time [s].

    Parameters
    ----------
    time : [s], or a text such as "50 ms", within the run
    """

    time: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        time = in_seconds("time", self.time)
        CHECKS["t"](f"{self.output_label}: time", time)
        object.__setattr__(self, "time", float(time))

    @property
    def title(self) -> str:
        return self.name or f"{self.output_label} at {self.time:g} s"

    def times(self, t: Array) -> Array | None:
        return np.array([float(self.time)])


@dataclass(frozen=True, eq=False)
class AtEvent(OneValue, Response):
    """Response: an output at an event that changes velocities or ends the run; of ``t``, the time of the event.

    Parameters
    ----------
    event : its name
    number : its number among the events of this name, from 1
    after : whether just after the event, instead of just before
    """

    event: str = ""
    number: int = 1
    after: bool = False

    @property
    def title(self) -> str:
        return (
            self.name or f"{self.output_label} {'after' if self.after else 'at'} {self.event} {self.number}"
        )


@dataclass(frozen=True, eq=False)
class Integral(Response):
    """Response: the integral of an output over time.

    Steps in which the output has a kink, as ``np.abs`` has at zero, are split there.
    """

    def unit(self, system: System) -> str:
        return product((super().unit(system), 1), ("s", 1))

    @property
    def pointwise(self) -> bool:
        return False

    @property
    def additive(self) -> bool:
        return True

    def value(self, g: Array, t: Array) -> float:
        return float(self.weights(g, t) @ g)

    def weights(self, g: Array, t: Array) -> Array:
        return self.layout.weights(t)

    def weights_along(self, g: Array, t: Array, g_dot: Array, t_dot: Array) -> Array:
        return self.layout.weights(t_dot)  # which is linear

    def by_times(self, g: Array, t: Array) -> Array:
        return self.layout.by_times(g)

    def by_times_along(self, g: Array, t: Array, g_dot: Array, t_dot: Array) -> Array:
        return self.layout.by_times(g_dot)


class ExtremeValue(Response):
    """The extreme of the polynomial through samples on both sides of the outermost sample of all steps.

    These samples are of states that the run reports. The polynomial being flat there, the derivatives of its value are
    those at a fixed time. At the ends of the run, and at an event, where an output may jump or have a corner, samples
    are on one side. At a kink, see `extremes`.
    """

    @property
    def pointwise(self) -> bool:
        return False

    sign = 1

    def outermost(self, g: Array) -> int:
        """Return the index of the extreme sample."""
        return int(np.argmax(self.sign * g))

    def value(self, g: Array, t: Array) -> float:
        return top_of(g, t, self.sign, self.layout).value

    def weights(self, g: Array, t: Array) -> Array:
        vertex = self._vertex(g, t)
        return vertex.placed(vertex.basis, len(g))

    def by_times(self, g: Array, t: Array) -> Array:
        vertex = self._vertex(g, t)
        return vertex.placed(vertex.by_times, len(g))

    def weights_along(self, g: Array, t: Array, g_dot: Array, t_dot: Array) -> Array:
        vertex = self._vertex(g, t)
        return vertex.placed(vertex.moved(g_dot, t_dot)[0], len(g))

    def by_times_along(self, g: Array, t: Array, g_dot: Array, t_dot: Array) -> Array:
        vertex = self._vertex(g, t)
        return vertex.placed(vertex.moved(g_dot, t_dot)[1], len(g))

    def _vertex(self, g: Array, t: Array) -> Vertex:
        return top_of(g, t, self.sign, self.layout).vertex(g, t)


@dataclass(frozen=True, eq=False)
class Maximum(ExtremeValue):
    """Response: the maximum of an output, also between steps; not smooth where two maxima are equal."""


@dataclass(frozen=True, eq=False)
class Minimum(ExtremeValue):
    """Response: the minimum of an output, also between steps."""

    sign = -1


@dataclass(frozen=True, eq=False)
class Misfit(Response):
    """Response: half the sum of squares of (output - data) / sigma at given times [s].

    Parameters
    ----------
    at : times of the measurements [s]
    data : measured values of the output
    sigma : standard deviation of the measurements
    """

    at: Sequence[float] = ()
    data: Sequence[float] = ()
    sigma: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        for what, given in (("times", self.at), ("data", self.data)):
            CHECKS["times"](f"{self.title}: its {what}", given)
        times, data = np.shape(self.at), np.shape(self.data)
        if len(times) != 1 or times != data or times == (0,):
            message = f"its times have the shape {times} and its data {data}"
            raise ValueError(f"{self.title}: {message}. Give a list with one measured number for each time.")
        if not (np.isfinite(self.sigma) and self.sigma > 0):
            raise ValueError(
                f"{self.title}: sigma must be greater than 0, but is {self.sigma:g}. "
                "Give the standard deviation of the data."
            )

    def unit(self, system: System) -> str:
        return "1"

    def times(self, t: Array) -> Array | None:
        return np.asarray(self.at, dtype=float)

    @property
    def additive(self) -> bool:
        return True

    def part(self, rows: Array) -> Misfit:
        at, data = (np.asarray(x)[rows].tolist() for x in (self.at, self.data))
        return replace(self, at=at, data=data)

    def residuals(self, g: Array) -> Array:
        """(output - data) / sigma (nt,)."""
        return np.asarray((g - np.asarray(self.data, dtype=float)) / self.sigma)

    def value(self, g: Array, t: Array) -> float:
        return 0.5 * float(np.sum(self.residuals(g) ** 2))

    def weights(self, g: Array, t: Array) -> Array:
        return np.asarray(self.residuals(g) / self.sigma)

    def weights_along(self, g: Array, t: Array, g_dot: Array, t_dot: Array) -> Array:
        return np.asarray(g_dot / self.sigma**2)


def of_whole_run(system: System, response: Response) -> Response:
    """The final value of an energy since the start as the integral of its power; any other response itself."""
    if type(response) is not Final or not isinstance(response.of, str):
        return response
    with suppress(UnknownOutput):
        if rate := find_output(system, response.of).rate:
            return Integral(rate, name=response.title)
    return response


def distinct_titles(titles: Iterable[str]) -> tuple[str, ...]:
    """Names in tables; the second of two that are equal ends with 2."""
    found: dict[str, None] = {}
    for title in titles:
        choices = (f"{title} {n}" if n > 1 else title for n in count(1))
        found[next(choice for choice in choices if choice not in found)] = None
    return tuple(found)
