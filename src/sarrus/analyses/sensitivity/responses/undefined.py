"""Responses that have no value or no derivative."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from ....algebra import Array
from ....model.tape import Tracer
from ....outputs import Outputs

ROOT = (
    ", as that of a root at 0. Use a smooth function, such as sqrt(x**2 + e**2), or leave out the measurement where "
    "the output is 0, or the response."
)


class UndefinedResponse(ValueError):
    """A response of a run that is not a number, or whose derivative is infinite."""


def refuse_undefined(titles: Iterable[str], values: Array) -> None:
    """Raise for the first response that is not a number.

    Raises
    ------
    UndefinedResponse
        With its name.
    """
    for title, value in zip(titles, values, strict=True):
        if not np.isfinite(value):
            raise UndefinedResponse(
                f"{title} is {value}: its output leaves where it is defined, as the root of a negative number does"
            )


def refuse_infinite(titles: Iterable[str], derivatives: Iterable[Array]) -> None:
    """Raise for the first response that has a derivative that is not finite.

    Raises
    ------
    UndefinedResponse
        With its name.
    """
    for title, found in zip(titles, derivatives, strict=True):
        if not np.isfinite(found).all():
            raise UndefinedResponse(f"{title}: its derivative is infinite{ROOT}")


def gradient_of(
    title: str,
    outputs: Outputs,
    found: Tracer,
    weights: Array,
    moves: bool = False,
    vanishing: Callable[[], Array] | None = None,
) -> list[Any]:
    """The gradient of a response by the entries of its tape.

    Parameters
    ----------
    title, outputs, found : of the response: its name, its tape with the inputs, and its output there
    weights : of the output at its times; infinite slopes do no harm where they are zero and remain so
    moves : whether it is differentiated by its times, too
    vanishing : which weights are zero only at this output, `Response.vanishing_weights`; none if omitted. Infinite
        slopes at their times do harm

    Raises
    ------
    UndefinedResponse
        If a derivative that is needed is not finite.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        bars = outputs.tape.gradient({found.at: weights})
        if not _finite(outputs, bars, moves):
            none = weights == 0.0
            bars = outputs.tape.gradient({found.at: weights}, none & ~vanishing() if vanishing else none)
    if not _finite(outputs, bars, moves):
        raise UndefinedResponse(f"{title}: its derivative is infinite{ROOT}")
    return bars


def change_of_gradient(
    title: str, outputs: Outputs, found: Tracer, bars: tuple[Array, Array], along: list[Any], moves: bool
) -> tuple[list[Any], list[Any]]:
    """The gradient of a response by the entries of its tape, and its change.

    Parameters
    ----------
    title, outputs, found, moves : as for `gradient_of`
    bars : the weights of the output at its times, and their change
    along : the change of every entry

    Raises
    ------
    UndefinedResponse
        If a second derivative that is needed is not finite.
    """
    given = {found.at: bars[0]}, {found.at: bars[1]}, along
    with np.errstate(divide="ignore", invalid="ignore"):
        both = outputs.tape.gradient_along(*given)
        if not all(_finite(outputs, one, moves) for one in both):
            both = outputs.tape.gradient_along(*given, (bars[0] == 0.0) & (bars[1] == 0.0))
    if not all(_finite(outputs, one, moves) for one in both):
        raise UndefinedResponse(f"{title}: its second derivative is infinite{ROOT}")
    return both


def along_with_weight(along: Array, none: Array, check: Callable[[], object]) -> Array:
    """The changes of an output at its times (nt, k), zero where they are infinite and do no harm.

    Parameters
    ----------
    along : the changes
    none : (nt,) at which times it has no weight
    check : raises an error where infinite slopes do harm
    """
    lost = none & ~np.isfinite(along).all(axis=1)
    if not lost.any():
        return along
    check()
    return np.where(lost[:, None], 0.0, along)


def change_with_weight(title: str, weights: Array, change: Array, turned: Callable[[Array], Array]) -> Array:
    """The change of an output at its times, zero where it is infinite and has no weight.

    Parameters
    ----------
    title, weights : of the response
    change : of the output
    turned : the change of the weights with that of the output

    Raises
    ------
    UndefinedResponse
        If the weights change with an infinite change.
    """
    lost = (weights == 0.0) & ~np.isfinite(change)
    if lost.any() and turned(lost.astype(float)).any():
        raise UndefinedResponse(f"{title}: its second derivative is infinite{ROOT}")
    return np.where(lost, 0.0, change)


def _finite(outputs: Outputs, bars: list[Any], moves: bool) -> bool:
    """Whether a gradient is, by everything that a response depends on."""
    return all(np.isfinite(bars[one]).all() for one in _variables(outputs, moves))


def _variables(outputs: Outputs, moves: bool) -> list[int]:
    """Places on its tape of everything that a response depends on."""
    times = [outputs.t] if moves else []
    return [one.at for one in (*outputs.inputs.values(), *outputs.named.values(), *times)]
