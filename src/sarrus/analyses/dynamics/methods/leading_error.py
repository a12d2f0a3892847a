"""Leading term of the local error of a described method, measured at q'' = -q, whose motion is known.

One step from (q, v) on the motion leads to q₁, v₁; the error is the greater of |q₁ - q| and h |v₁ - v|. Its order in h
and its constant follow from two step sizes. Multistep methods are measured where their history has become that of many
equal steps, and once more at their first step, whose history is what `Description.extra` gives.
"""

from __future__ import annotations

from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ....algebra import Array
from .description import COORDINATES, Affine, Description, Step

SIZES = 0.2, 0.1  # of steps
SETTLING, MEASURED = 32, 32  # steps before those that are measured, and how many these are
PHASES = np.linspace(0.0, np.pi, 8, endpoint=False)  # of the motions whose first steps are measured


class ErrorTerm(NamedTuple):
    """An error of constant x h^exponent x the derivative of q of this order."""

    exponent: int
    constant: float


class LeadingErrors(NamedTuple):
    """Leading errors of the first step, and of steps after many equal ones."""

    first: ErrorTerm
    later: ErrorTerm


_MEASURED: WeakKeyDictionary[Description, LeadingErrors] = WeakKeyDictionary()


def leading_errors(method: Description) -> LeadingErrors:
    """The leading errors of a method; those of its estimate where it gives one.

    Raises
    ------
    ValueError
        If the method does not approach the motion as its steps become shorter.
    """
    if method.error is not None:
        own = ErrorTerm(method.error.order + 1, method.error.constant)
        return LeadingErrors(own, own)
    if method not in _MEASURED:
        first = _leading(method, *(_first_error(method, h) for h in SIZES))
        _MEASURED[method] = LeadingErrors(first, _leading(method, *(_later_error(method, h) for h in SIZES)))
    return _MEASURED[method]


def _leading(method: Description, long: float, short: float) -> ErrorTerm:
    """Return the leading error from the errors of steps of two sizes."""
    ratio = long / short if short > 0 else np.nan
    if not ratio > 2.8:  # h^1.5: an error of h² is the largest with which a method converges
        raise ValueError(
            f"{method.name}: the method does not converge: a step of q'' = -q has an error of {short:.3g} for "
            f"h = {SIZES[1]}, and of {long:.3g} for h = {SIZES[0]}. Check its coefficients."
        )
    exponent = max(round(np.log2(ratio)), 2)
    return ErrorTerm(exponent, short / SIZES[1] ** exponent)


def _first_error(method: Description, h: float) -> float:
    return max(_step_error(method, _start(method, np.cos(phase), -np.sin(phase)), h)[1] for phase in PHASES)


def _later_error(method: Description, h: float) -> float:
    state, largest = _start(method, 1.0, 0.0), 0.0
    for n in range(SETTLING + MEASURED):
        size = np.hypot(state["q"], state["v"])
        state, error = _step_error(method, state, h)
        largest = max(largest, error / size) if n >= SETTLING else 0.0
    return float(largest)


def _start(method: Description, q: float, v: float) -> dict[str, float]:
    state = {"q": q, "v": v, "a": -q}
    return state | {name: _value(by, state) for name, by in method.extra.items()}


def _step_error(method: Description, state: dict[str, float], h: float) -> tuple[dict[str, float], float]:
    """The state after a step, and its error."""
    after = _after(method, method.step(h, 1.0), state)
    q = state["q"] * np.cos(h) + state["v"] * np.sin(h)
    v = state["v"] * np.cos(h) - state["q"] * np.sin(h)
    return after, float(max(abs(after["q"] - q), h * abs(after["v"] - v)))


def _after(method: Description, step: Step, state: dict[str, float]) -> dict[str, float]:
    """Take one step with one free coordinate, whose equations are linear in the unknowns."""
    names = [name for name, size in method.unknowns.items() if size == COORDINATES]
    zero = state | dict.fromkeys(names, 0.0)
    constant = _residuals(step, zero)
    columns = [_residuals(step, zero | {name: 1.0}) - constant for name in names]
    z = np.linalg.solve(np.column_stack(columns), -constant)
    known = state | dict(zip(names, z.tolist(), strict=True))
    after = state | {name: _value(by, known) for name, by in step.update.items() if name in state}
    return after if "a" in step.update else after | {"a": -after["q"]}


def _residuals(step: Step, known: dict[str, float]) -> Array:
    found = list[float]()
    for kind, s, *_ in step.equations:
        stage = step.stages[s]
        if kind == "motion":
            found.append(_value(stage.a, known) + _value(stage.q, known))
        elif kind == "kinematic":
            found.append(_value(stage.rate, known))
    return np.array(found)


def _value(affine: Affine, known: dict[str, float]) -> float:
    return float(sum(factor * known[name] for name, factor in affine.items()))
