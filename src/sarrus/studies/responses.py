"""Responses of a run as formulas: ``max(slider.x) - min(slider.x)``, ``integral(abs(motor.torque.x))``.

Names are outputs of a motion, and parameters of the model. Inside a reduction they are histories over time; a history
that is not reduced means its final value. `differentiable` makes responses of them whose derivatives are exact.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeGuard

import numpy as np

from ..analyses.sensitivity import Response as Differentiable
from ..analyses.sensitivity.combined import Combined, response_of
from ..analyses.sensitivity.sampling.segments import refuse_outside
from ..model import Expression, ModelError, SarrusError
from ..model.expression import Call, Number, parse
from ..model.expression.tree import Function
from ..outputs.reductions import ERROR, is_reduction, reduction
from .parameters import Array

Lookup = Callable[[str], Any]


def reductions(t: Array) -> dict[str, Function]:
    """The functions that reduce a history over the times t to one number.

    ``final(x)``, ``initial(x)``, ``at(x, t)``, ``min(x)``, ``max(x)``, ``mean(x)`` over time, ``integral(x)`` over
    time (trapezoidal rule), ``rms(x)``: the root of the mean square. Also ``min(x, y)`` and ``max(x, y)``, moment by
    moment; and ``error(max(x))``, the estimated error of a response of a simulation.
    """
    times = np.asarray(t, dtype=float)
    span = float(times[-1] - times[0]) if len(times) > 1 else 0.0

    def over(x: Any) -> Array:
        return np.broadcast_to(np.asarray(x, dtype=float), times.shape)

    def mean(x: Any) -> float:
        return float(np.trapezoid(over(x), times)) / span if span else float(over(x)[-1])

    def at(x: Any, when: Any) -> float:
        refuse_outside(np.atleast_1d(when), times[0], times[-1])
        return float(np.interp(when, times, over(x)))

    functions: dict[str, Callable[..., float]] = {
        "final": lambda x: float(over(x)[-1]),
        "initial": lambda x: float(over(x)[0]),
        "at": at,
        "min": lambda x: float(over(x).min()),
        "max": lambda x: float(over(x).max()),
        "mean": mean,
        "rms": lambda x: float(np.sqrt(mean(over(x) ** 2))),
        "integral": lambda x: float(np.trapezoid(over(x), times)),
        ERROR: lambda _: 1.0,  # which is not made of histories, see `Response.value`
    }
    return {name: reduction(name, value) for name, value in functions.items()}


@dataclass(frozen=True)
class Response:
    """A number that a run has: a formula, or a function of the result."""

    name: str
    of: str | Callable[[Any], float]

    def __post_init__(self) -> None:
        if isinstance(self.of, str):
            self.tree(np.zeros(1))

    def tree(self, t: Array) -> Expression:
        """Its formula, with reductions over the times t."""
        try:
            return parse(str(self.of), functions=reductions(t))
        except ModelError as wrong:
            raise SarrusError(f"response {self.name!r} {wrong.message}") from None

    def times(self) -> tuple[float, ...]:
        """The times [s] at which it asks for a value."""
        if not isinstance(self.of, str):
            return ()
        nodes = [node for node in self.tree(np.zeros(1)).nodes() if isinstance(node, Call)]
        return tuple(
            float(node.args[1].value())
            for node in nodes
            if node.function.name == "at" and not node.args[1].names()
        )

    @property
    def of_errors(self) -> bool:
        """Whether it asks for an estimated error, for which steps must be stored."""
        return isinstance(self.of, str) and any(map(_is_error, self.tree(np.zeros(1)).nodes()))

    def names(self) -> tuple[str, ...]:
        """The names of outputs and numbers in its formula."""
        return self.tree(np.zeros(1)).names() if isinstance(self.of, str) else ()

    def value(self, result: Any, t: Array, lookup: Lookup) -> float:
        """Its value.

        Raises
        ------
        SarrusError
            If it is not one finite number.
        """
        if isinstance(self.of, str):
            tree = self._with_errors(self.tree(t), result) if self.of_errors else self.tree(t)
            value = tree.value({name: lookup(name) for name in tree.names()})
        else:
            value = self.of(result)
        number = float(np.ravel(value)[-1]) if np.size(value) else np.nan
        if not np.isfinite(number):
            raise SarrusError(
                f"response {self.name!r} is {number}, no finite number. Use a function that is defined there."
            )
        return number

    def _with_errors(self, tree: Expression, result: Any) -> Expression:
        """The formula with the numbers of the errors that it asks for."""

        def number(node: Expression) -> Number | None:
            return Number(_error_of(replace(self, of=str(node.args[0])), result)) if _is_error(node) else None

        return tree.rebuilt(number)


def _is_error(node: Expression) -> TypeGuard[Call]:
    return is_reduction(node) and node.function.name == ERROR


def _error_of(response: Response, run: Any) -> float:
    """The estimated error of a response of a run.

    Raises
    ------
    SarrusError
        For analyses other than simulations, and as for `differentiable`.
    """
    if getattr(run, "steps", None) is None:
        raise SarrusError(
            f"response {response.name!r}: errors are estimated of simulations. Leave error() out."
        )
    return float(run.error(differentiable(response)).error)


def responses_of(responses: Any) -> tuple[Response, ...]:
    """Responses of what a user writes: a mapping of names to formulas or functions, a list of formulas, or one.

    Raises
    ------
    SarrusError
        For anything else, and if two have the same name.
    """
    if isinstance(responses, Mapping):
        return tuple(Response(str(name), _formula(of, name)) for name, of in responses.items())
    if isinstance(responses, str) or callable(responses):
        responses = [responses]
    if not isinstance(responses, Sequence):
        raise SarrusError(
            f"responses must be formulas such as max(slider.x), but are {responses!r:.60}. Give one or several."
        )
    titles = [_title(of) for of in responses]
    if len(set(titles)) < len(titles):
        raise SarrusError("two responses have the same name. Give each its own, as in {'final': 'slider.x'}.")
    return tuple(Response(title, _formula(of, title)) for title, of in zip(titles, responses, strict=True))


def _formula(of: Any, name: Any) -> str | Callable[[Any], float]:
    if isinstance(of, str):
        return of
    if callable(of):
        function: Callable[[Any], float] = of
        return function
    raise SarrusError(f"response {name!r} must be a formula such as max(slider.x), but is {of!r}. Give one.")


def _title(of: Any) -> str:
    return of if isinstance(of, str) else str(getattr(of, "__name__", "response"))


def described(responses: tuple[Response, ...]) -> Iterator[tuple[str, str]]:
    """Name and formula of each; of a function, its module and name."""
    for response in responses:
        of: Any = response.of
        formula = of if isinstance(of, str) else f"{of.__module__}.{getattr(of, '__qualname__', 'function')}"
        yield response.name, formula


def differentiable(response: Response) -> Differentiable | Combined:
    """The same response for `sensitivity`, `Problem` and `optimize`.

    Raises
    ------
    SarrusError
        For a Python function, and a formula without derivatives or any output.
    """
    if not isinstance(response.of, str):
        raise SarrusError(
            f"response {response.name!r} is a function, whose derivatives are unknown. Give a formula."
        )
    return response_of(response.of, response.name)
