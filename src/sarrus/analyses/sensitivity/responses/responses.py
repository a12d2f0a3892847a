"""Responses: numbers that a motion has, each made of an output over time in one way; with exact derivatives.

An output is given by its name, or as a function of `Outputs` that computes its value alone.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import count
from typing import Any, TypeAlias

import numpy as np

from ....algebra import Array
from ....model.registry import described
from ....model.tape import Tracer
from ....outputs import Outputs, UnknownOutput, find_output
from ....outputs.units import product
from ....system import System
from .panels import Layout
from .peaks import Peaks, Vertex, top_of, vertex_of

Output: TypeAlias = str | Callable[[Any], Any]


@dataclass(frozen=True, eq=False)
class Response:
    """Base class of responses.

    Parameters
    ----------
    of : name of an output, a formula of outputs, or a function of `Outputs`
    name : name in results; by default made from the output's name
    layout : for internal use: the samples of a response over the whole run
    reported : for internal use: kinds of states that are taken as the run reports them, if one of them is needed
    """

    of: Output
    name: str = ""
    layout: Layout | None = field(default=None, repr=False, kw_only=True)
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

    def at_kinks(self, g: Array, t: Array) -> Array:
        """Return the derivatives with respect to integrals of the output over parts of the run, at each time (nt,)."""
        return np.zeros_like(g)

    def by_times_along(self, g: Array, t: Array, g_dot: Array, t_dot: Array) -> Array:
        """Return the change of the weights with the output and the times."""
        return np.zeros_like(g)

    def rule(self, t: Array) -> Array:
        """The weights of its times in integrals over the run."""
        if self.layout:
            return self.layout.weights(t)
        return 0.5 * (np.diff(t, prepend=t[0]) + np.diff(t, append=t[-1]))

    def rule_by_times(self, g: Array) -> Array:
        """The derivatives by the times of what these weights make of an output."""
        if self.layout:
            return self.layout.by_times(g)
        return -np.diff(0.5 * (g[1:] + g[:-1]), prepend=0.0, append=0.0)

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
    time : [s], within the run
    """

    time: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if np.ndim(self.time) or not np.isfinite(self.time):
            raise ValueError(
                f"{self.output_label}: time must be one number of seconds, but is {self.time}. Give a time of the run."
            )

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

    def value(self, g: Array, t: Array) -> float:
        return float(self.rule(t) @ g)

    def weights(self, g: Array, t: Array) -> Array:
        return self.rule(t)

    def weights_along(self, g: Array, t: Array, g_dot: Array, t_dot: Array) -> Array:
        return self.rule(t_dot)  # which is linear

    def at_kinks(self, g: Array, t: Array) -> Array:
        return np.ones_like(g)

    def by_times(self, g: Array, t: Array) -> Array:
        return self.rule_by_times(g)

    def by_times_along(self, g: Array, t: Array, g_dot: Array, t_dot: Array) -> Array:
        return self.rule_by_times(g_dot)


class ExtremeValue(Response):
    """The extreme of the polynomial through samples on both sides of the outermost sample of all steps.

    These samples are of states that the run reports; by checkpoints they are the three about the outermost one. The
    polynomial being flat there, the derivatives of its value are those at a fixed time. At the ends of the run, and at
    an event, where an output may jump or have a corner, samples are on one side. At a kink, see `peaks`.
    """

    @property
    def pointwise(self) -> bool:
        return False

    sign = 1

    def outermost(self, g: Array) -> int:
        """Return the index of the extreme sample."""
        return int(np.argmax(self.sign * g))

    def value(self, g: Array, t: Array) -> float:
        if self.layout:
            return top_of(g, t, self.sign, self.layout).value
        return float(self.weights(g, t) @ g)

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
        if self.layout is None:
            return vertex_of(g, t, self.outermost(g))
        return top_of(g, t, self.sign, self.layout).vertex(g, t)


@dataclass(frozen=True, eq=False)
class Peak(Response):
    """Response: a smooth maximum of an output, for peaks of nearly equal height.

    By default, the value is a mean of all peaks, weighted with exp(s peak), where s is 1000 over the range of the
    output. It is less than the maximum by at most 0.0003 of the range, and equal to it if one peak is higher than the
    others by more than some thousandths of the range.

    With a `sharpness`, the value is ln(mean of exp(sharpness g)) / sharpness, with the mean over time. It is smooth,
    but below the maximum, in particular for short peaks. For a value near the maximum, use some thousand over the range
    of the output and short steps, or `Maximum`.
    """

    sharpness: float | None = None

    @property
    def pointwise(self) -> bool:
        return False

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.sharpness is not None and not 0 < self.sharpness < np.inf:
            raise ValueError(
                f"{self.title}: sharpness must be greater than 0, but is {self.sharpness:g}. Give a positive number."
            )

    def value(self, g: Array, t: Array) -> float:
        if self.sharpness is None:
            return Peaks(g, t).value
        top = float(g.max())
        mean = self.rule(t) @ np.exp(self.sharpness * (g - top)) / (t[-1] - t[0])
        return top + float(np.log(mean)) / self.sharpness

    def weights(self, g: Array, t: Array) -> Array:
        if self.sharpness is None:
            return Peaks(g, t).weights()
        share: Array = self.rule(t) * np.exp(self.sharpness * (g - g.max()))
        return np.asarray(share / share.sum())

    def by_times(self, g: Array, t: Array) -> Array:
        if self.sharpness is None:
            return Peaks(g, t).by_times()
        share = np.exp(self.sharpness * (g - g.max()))
        by_length = _by_length(t) / (t[-1] - t[0])
        return np.asarray((self.rule_by_times(share) / (self.rule(t) @ share) - by_length) / self.sharpness)

    def weights_along(self, g: Array, t: Array, g_dot: Array, t_dot: Array) -> Array:
        if self.sharpness is None:
            return Peaks(g, t).along(g_dot, t_dot)[0]
        share, share_dot, whole, whole_dot = self._shares(g, t, g_dot, t_dot)
        change = self.rule(t_dot) * share + self.rule(t) * share_dot
        return np.asarray(change / whole - self.weights(g, t) * whole_dot / whole)

    def by_times_along(self, g: Array, t: Array, g_dot: Array, t_dot: Array) -> Array:
        if self.sharpness is None:
            return Peaks(g, t).along(g_dot, t_dot)[1]
        share, share_dot, whole, whole_dot = self._shares(g, t, g_dot, t_dot)
        change = self.rule_by_times(share_dot) - self.rule_by_times(share) * whole_dot / whole
        length, length_dot = t[-1] - t[0], t_dot[-1] - t_dot[0]
        return np.asarray((change / whole + _by_length(t) * length_dot / length**2) / self.sharpness)

    def _shares(self, g: Array, t: Array, g_dot: Array, t_dot: Array) -> tuple[Array, Array, float, float]:
        """exp(sharpness g) over its maximum, and its integral; each with its change."""
        assert self.sharpness is not None
        share: Array = np.exp(self.sharpness * (g - g.max()))
        share_dot: Array = self.sharpness * g_dot * share
        return (
            share,
            share_dot,
            float(self.rule(t) @ share),
            float(self.rule(t_dot) @ share + self.rule(t) @ share_dot),
        )

    def at_kinks(self, g: Array, t: Array) -> Array:
        if self.sharpness is None:
            return np.zeros_like(g)
        share = np.exp(self.sharpness * (g - g.max()))
        return np.asarray(share / (self.rule(t) @ share))


@dataclass(frozen=True, eq=False)
class Maximum(ExtremeValue):
    """Response: the maximum of an output, also between steps; not smooth where two maxima are equal, see `Peak`."""


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
        if not len(self.at) == len(self.data) > 0:
            message = f"{len(self.at)} times and {len(self.data)} data"
            raise ValueError(f"{self.title}: there are {message}. Give one measured number for each time.")
        for what, given in (("times", self.at), ("data", self.data)):
            if not np.isfinite(np.asarray(given, dtype=float)).all():
                raise ValueError(f"{self.title}: its {what} are not all finite numbers. Leave gaps out.")
        if not (np.isfinite(self.sigma) and self.sigma > 0):
            raise ValueError(
                f"{self.title}: sigma must be greater than 0, but is {self.sigma:g}. "
                "Give the standard deviation of the data."
            )

    def unit(self, system: System) -> str:
        return "1"

    def times(self, t: Array) -> Array | None:
        return np.asarray(self.at, dtype=float)

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


def _by_length(t: Array) -> Array:
    """The derivatives of the length of a run by the times (nt,)."""
    found = np.zeros_like(t)
    found[0], found[-1] = -1.0, 1.0
    return found
