"""Growth of the adjoint: how many digits of derivatives are left in chaotic and unstable motions.

Errors of the states of a run are carried to the response, and change what the run is linearized about, as the adjoint
grows from the end of the run backwards.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from ....algebra import Array
from ....results import ErrorEstimate, Pieces, StepsTaken
from ..chain.chain import Nodes

FEW = 2.0  # digits, below which there is a warning
GROWN = 1e5  # by so much, at most, adjoints of regular motions grow: in proportion to their duration
# The same of methods of order 2 with error control: errors of a regular motion are visible after as many periods
GROWN_ORDER_TWO = 200.0
LARGER = 5.0  # times rtol^(2/3): relative error of derivatives by a method of order 2 over the growth
EVEN = 1e-6  # of a step: how much steps of a given length differ
INEXACT = 0.3  # estimated relative error of derivatives, above which they have hardly a digit
EPS = float(np.finfo(float).eps)
STATES = ("q", "v", "a", "lam")


class Growth:
    """Growth of the adjoints of responses in a run, section by section.

    Adjoints are in units of the response: gradients times how much coordinates, velocities, accelerations and
    multipliers vary within the run, and those by times of events times its duration. They are compared with what the
    response takes from states by itself: of regular motions their ratio is about one.
    """

    def __init__(self) -> None:
        self._low: dict[str, Array] = {}
        self._high: dict[str, Array] = {}
        self._own: dict[str, Array] = {}
        self._largest: Array = np.zeros(1)
        self._times = np.inf, -np.inf
        self._steps = np.inf, -np.inf

    def take(self, steps: StepsTaken | Pieces, given: Nodes, adjoints: Sequence[Array]) -> None:
        """A stretch of the run: gradients by its states, and its adjoints as `Stretches` stores them."""
        pieces = steps.pieces if isinstance(steps, Pieces) else (steps,)
        for name in STATES:
            found = np.concatenate([getattr(one, name) for one in pieces])
            self._low[name] = np.minimum(self._low.get(name, np.inf), found.min(axis=0))
            self._high[name] = np.maximum(self._high.get(name, -np.inf), found.max(axis=0))
            self._own[name] = self._own.get(name, 0.0) + abs(getattr(given, name)).sum(axis=0)
        self._own["shift"] = self._own.get("shift", 0.0) + abs(given.shift).sum(axis=0)
        for own in adjoints:
            self._largest = np.maximum(self._largest, abs(own[:, 0]).max(axis=0, initial=0.0))
        lengths = np.concatenate([one.h[:-1] for one in pieces])  # the last one may be cut
        self._steps = lengths.min(initial=self._steps[0]), lengths.max(initial=self._steps[1])
        self._times = min(self._times[0], pieces[0].t[0]), max(self._times[1], pieces[-1].t[-1])

    def _sizes(self) -> dict[str, Array]:
        return {name: self._high[name] - self._low[name] for name in STATES}

    def own(self) -> Array:
        """Return the direct variation of each response with the states (k,)."""
        own = (self._times[1] - self._times[0]) * self._own["shift"]
        return np.asarray(own + sum(size @ self._own[name] for name, size in self._sizes().items()))

    def values(self) -> Array:
        """The largest adjoint of each response over what it takes from states by itself, at least 1 (k,)."""
        sizes, own = self._sizes(), self.own()
        largest = np.concatenate([sizes["q"], sizes["v"]]) @ self._largest
        grown = np.divide(largest, own, out=np.ones_like(own), where=own > 0)
        return np.asarray(np.maximum(grown, 1.0))

    def warnings(self, titles: Iterable[str], rtol: float, precise: bool) -> Iterator[str]:
        """Return one message for each response whose derivatives have few digits; `precise` as in `StepsTaken`."""
        # of the order of the error of one period
        of_states = rtol ** (5 / 6) if precise else LARGER * rtol ** (2 / 3)
        even = self._steps[1] <= (1 + EVEN) * self._steps[0]
        least, have = (GROWN, "have") if precise or even else (GROWN_ORDER_TWO, "may have")
        for title, growth in zip(titles, self.values(), strict=True):
            digits, most = (-np.log10(growth * x) for x in (of_states, EPS))
            if growth >= least and digits < FEW:
                few = f"about {digits:.0f} digits" if digits >= 1 else "no correct digit"
                remedy = "Choose smaller tolerances" if most >= FEW else "Choose a shorter run"
                yield f"{title}: its derivatives {have} {few}, as the adjoint grows by {growth:.0e}. {remedy}."

    def relative_errors(self, estimates: Sequence[ErrorEstimate]) -> tuple[float, ...]:
        """Estimated relative errors of the derivatives of responses, of those of their values.

        They are of the size of the error of the value, over how much the response varies, times the growth.
        """
        errors, own = np.array([one.error for one in estimates]), self.own()
        return tuple(np.divide(self.values() * errors, own, out=np.zeros(len(own)), where=own > 0).tolist())

    def warnings_of_errors(self, estimates: Sequence[ErrorEstimate]) -> Iterator[str]:
        """Return one message for each response whose error leaves hardly a digit of its derivatives."""
        for one, growth, found in zip(estimates, self.values(), self.relative_errors(estimates), strict=True):
            if found > INEXACT:
                yield (
                    f"{one.response}: its derivatives have no digit that is sure, as its value is off by "
                    f"{one.error:.1e} and the adjoint grows by {growth:.0e}. Choose smaller tolerances, or a method of "
                    "higher order."
                )


def growth_of(steps: StepsTaken | Pieces, given: Nodes, adjoints: Sequence[Array]) -> Growth:
    """Return the growth in a whole run."""
    found = Growth()
    found.take(steps, given, adjoints)
    return found


def warnings_of_growth(
    steps: StepsTaken | Pieces, titles: Iterable[str], given: Nodes, adjoints: Sequence[Array]
) -> list[str]:
    """Return the warnings of a whole run."""
    first = steps.pieces[0] if isinstance(steps, Pieces) else steps
    return [*growth_of(steps, given, adjoints).warnings(titles, first.rtol, first.precise)]
