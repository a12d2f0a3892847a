"""Growth of the adjoint and number of steps: how many digits of derivatives are left, at least, by a cheap measure.

Errors of the states of a run are carried to the response, and change what the run is linearized about, as the adjoint
grows from the end of the run backwards. Where it does not, errors add up over periods, contacts and events.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from .....algebra import Array
from .....results import Pieces, StepsTaken
from .....results.motion.steps import stretches
from ...chain.chain import STATES, Nodes
from ..estimate import BODY

ENOUGH = 3.3  # digits by growth and number of steps, below which errors of states are estimated
# Times rtol: error by a step of a regular motion, of methods of order 2 and higher
STEPS = {False: 3.0, True: 1.0}
# Times rtol^(2/3): relative error of derivatives by a method of order 2 over the growth, at most
LARGER = 5.0
CONTACTS = 30.0  # the same in runs with contacts, of which derivatives lose more digits than states
DERIVATIVES = {1: "derivatives", 2: "second derivatives"}
WARNED = {1: 0.01, 2: 0.03}  # relative errors of derivatives of an order from which there is a warning
# Errors by one to three random changes are clear where they are larger or smaller than `WARNED` by these factors: twice
# `WARNED` is missed in 3 % of cases; one change alone may see nothing of a large error
OVER, UNDER = 1.5, (np.inf, 3.0, 2.0)
WRONG, NONE = 0.03, 0.3  # relative errors from which there is one digit, and hardly one
WARNED_SMALL = 0.005  # the same for those that are small: these estimates may be a quarter of the error
SMALL = 1.4  # factor of the estimate from which derivatives are named as small
GROWING = 100.0  # growth of the adjoint from which it is named as the cause
# Relative errors of derivatives over that of first ones: 0.4 to 20 for second ones of a double pendulum over 10 s
OF_ORDER = {1: 1.0, 2: 5.0}
PRESCRIBED = 1e-10  # largest adjoint before a step over gradients by states, of responses that are prescribed
EPS = float(np.finfo(float).eps)


class RelativeErrors(NamedTuple):
    """Relative errors of derivatives of responses (k,), those by round-off, and factors of `small_derivatives`."""

    values: Array
    by_round_off: Array
    factors: Array

    def without(self, which: Array) -> RelativeErrors:
        """The same, but zero for some responses (k,)."""
        values, by_round_off = (np.where(which, 0.0, one) for one in self[:2])
        return self._replace(values=values, by_round_off=by_round_off)

    def with_changes(self, changes: Array | None, which: Array, order: int = 1) -> RelativeErrors:
        """The same, but those by `error_changes` (k,) of first derivatives, if there are any, of some responses."""
        if changes is None:
            return self
        values = np.where(which, np.hypot(OF_ORDER[order] * changes, self.by_round_off), self.values)
        return self._replace(values=values, factors=np.where(which, 1.0, self.factors))


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
        self._steps, self._events = 0, 0

    def take(self, steps: StepsTaken | Pieces, given: Nodes, adjoints: Sequence[Array]) -> None:
        """A stretch of the run: gradients by its states, and its adjoints as `Stretches` stores them."""
        pieces = stretches(steps)
        self._steps += sum(map(len, pieces))
        self._events += len(pieces) - 1
        for name in STATES:
            found = np.concatenate([getattr(one, name) for one in pieces])
            self._low[name] = np.minimum(self._low.get(name, np.inf), found.min(axis=0))
            self._high[name] = np.maximum(self._high.get(name, -np.inf), found.max(axis=0))
            self._own[name] = self._own.get(name, 0.0) + abs(getattr(given, name)).sum(axis=0)
        self._own["shift"] = self._own.get("shift", 0.0) + abs(given.shift).sum(axis=0)
        for own in adjoints:
            self._largest = np.maximum(self._largest, abs(own[:, 0]).max(axis=0, initial=0.0))
        self._times = min(self._times[0], pieces[0].t[0]), max(self._times[1], pieces[-1].t[-1])

    def sizes(self) -> dict[str, Array]:
        """How much coordinates, velocities, accelerations and multipliers vary within the run."""
        return {name: self._high[name] - self._low[name] for name in STATES}

    def own(self) -> Array:
        """Return the direct variation of each response with the states (k,)."""
        own = (self._times[1] - self._times[0]) * self._own["shift"]
        return np.asarray(own + sum(size @ self._own[name] for name, size in self.sizes().items()))

    def values(self) -> Array:
        """The largest adjoint of each response over what it takes from states by itself, at least 1 (k,)."""
        sizes, own = self.sizes(), self.own()
        largest = np.concatenate([sizes["q"], sizes["v"]]) @ self._largest
        grown = np.divide(largest, own, out=np.ones_like(own), where=own > 0)
        return np.asarray(np.maximum(grown, 1.0))

    def prescribed(self) -> Array:
        """Whether drivers give responses (k,): they depend on no state before them, but for round-off."""
        own = np.max([self._own[name].max(axis=0) for name in STATES], axis=0)
        return np.asarray(self._largest.max(axis=0) <= PRESCRIBED * own)

    def groups(self) -> Iterator[tuple[Array, Array]]:
        """Responses that depend on the same bodies: which bodies, and the numbers of the responses."""
        felt = self._largest.reshape(2, -1, BODY, self._largest.shape[-1]).any(axis=(0, 2))
        felt |= ~felt.any(axis=0)  # responses that depend on none
        groups, own = np.unique(felt, axis=1, return_inverse=True)
        for n, which in enumerate(groups.T):
            yield which, np.flatnonzero(own.ravel() == n)

    def digits(self, rtol: float, precise: bool) -> Array:
        """Digits that derivatives of each response have at least (k,); `precise` as in `StepsTaken`.

        This is for errors of states that grow as the adjoint does, which most do not.
        """
        return np.asarray(-np.log10(self.values() * added_up(self._steps, self._events, rtol, precise)))

    def warnings_of_errors(
        self,
        titles: Iterable[str],
        errors: RelativeErrors,
        order: int = 1,
    ) -> Iterator[str]:
        """Return one message for each response if the relative error of derivatives of this order leaves few digits."""
        every = np.array([*titles], dtype=object), self.values(), *errors
        for title, growth, relative_error, by_round_off, factor in np.broadcast(*every):
            curable = by_round_off < NONE
            remedy = "smaller tolerances, or a method of higher order" if curable else "a shorter run"
            if not relative_error <= (WARNED_SMALL if factor > SMALL else WARNED[order]):
                cause = (
                    f"the adjoint grows by {growth:.0e}"
                    if growth > GROWING
                    else "errors of the states add up over the run"
                )
                if factor > SMALL:
                    cause += " and these derivatives are small compared with those within the run"
                yield (
                    f"{title}: its {DERIVATIVES[order]} have {few(relative_error)}, with a relative error of some "
                    f"{relative_error:.0e}, as {cause}. Choose {remedy}."
                )


def added_up(steps: int, events: int, rtol: float, precise: bool) -> float:
    """The error of states over the size of a regular motion: of each stretch that of a period, and of each step.

    A step of a method of order p is rtol^(1/(p + 1)) of a period, whose error is of the order rtol^(p/(p + 1)).
    """
    of_period = rtol ** (5 / 6) if precise else LARGER * (CONTACTS if events else 1.0) * rtol ** (2 / 3)
    return float(max(of_period * (events + 1), STEPS[precise] * rtol * steps))


def doubtful(steps: int, events: int, rtol: float, precise: bool) -> bool:
    """Whether a run has so many steps and events that errors of states are estimated however adjoints grow."""
    return bool(added_up(steps, events, rtol, precise) > 10.0**-ENOUGH)


def certain(relative_errors: Array, changes: int, warned: float) -> bool:
    """Whether errors of derivatives by a number of random changes are clearly above or below the warning."""
    under = UNDER[min(changes, len(UNDER)) - 1]
    return bool(np.all((relative_errors > OVER * warned) | (relative_errors <= warned / under)))


def few(relative_error: float) -> str:
    """Return how many digits derivatives have, in words."""
    if relative_error < WRONG:
        return "about two digits"
    return "about one digit" if relative_error < NONE else "no correct digit"


def growth_of(steps: StepsTaken | Pieces, given: Nodes, adjoints: Sequence[Array]) -> Growth:
    """Return the growth in a whole run."""
    found = Growth()
    found.take(steps, given, adjoints)
    return found
