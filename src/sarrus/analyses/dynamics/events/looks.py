"""Signs of the functions of corners at places of every step, and their rates: which steps may pass a corner."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....algebra import Array

PLACES = np.linspace(0, 1, 5)  # parts of a step at which signs are compared
AHEAD_OF = 1e-6  # of a step: between two states that give the rate of a function
LOOKS = np.sort([*PLACES[1:], *(PLACES[:-1] + AHEAD_OF), 1 - AHEAD_OF])  # where functions are evaluated
LANDS = 1e-3  # of what a function changes within a step: a step that ends so near to a corner may have been held there
OWN, AHEAD = (
    np.array([0, 2, 4, 6, 9]),
    np.array([1, 3, 5, 7, 8]),
)  # of the step's begin and these: places, and rates'


class Looks(NamedTuple):
    """Functions at five places of every step (corners, steps, 5), and between which of them (corners, steps, 4) signs
    change of forces that act, or functions reverse where they come near to zero; where functions return to zero at the
    end of a step, where they have come to it there, and where their force acts, or does not, in the middle only
    (corners, steps).
    """

    values: Array
    passed: Array
    dips: Array
    returns: Array
    lands: Array
    inside: Array

    def back(self, steps: Array) -> Looks:
        """Return the signs without those that change once in their step and do not return at its end.

        A step from a flight into a hard contact can end in it with the speed of its end already reversed. The force of
        a damped contact sets in by the depth, and ends by its rate.
        """
        counts = np.zeros((len(self.passed), int(steps.max(initial=0)) + 1), np.int64)
        np.add.at(counts.T, steps, self.passed.sum(axis=2).T)
        again = (counts[:, steps] > 1) | self.returns | self.inside
        return self._replace(passed=self.passed & again[:, :, None])

    @classmethod
    def of(cls, values: Array, acts: Array) -> Looks:
        """Create it from the functions and the activity of forces at the first node and at `LOOKS` of every step."""
        every, acting = _with_begin(values), _with_begin(acts)[:, :, OWN]
        own = every[:, :, OWN]
        slopes = (every[:, :, AHEAD] - own) / (np.append(0, LOOKS)[AHEAD] - PLACES)
        x, y, down, up = own[:, :, :-1], own[:, :, 1:], slopes[:, :, :-1], slopes[:, :, 1:]
        passed = (x * y < 0) & (acting[:, :, 1:] | acting[:, :, :-1])
        with np.errstate(all="ignore"):
            least = x + down * (y - x - up * np.diff(PLACES)) / (down - up)  # where tangents meet
        dips = (x * y > 0) & (x * down < 0) & (y * up > 0) & ~(x * least > 0)
        lands = abs(own[:, :, -1]) < LANDS * np.ptp(own, axis=2)
        first, middle, last = acting[:, :, 0], acting[:, :, 1:-1], acting[:, :, -1]
        inside = (first == last) & np.any(middle != first[:, :, None], axis=2)
        return cls(own, passed, dips, own[:, :, -1] * slopes[:, :, -1] < 0, lands, inside)


def _with_begin(at: Array) -> Array:
    """Values at the first node and at `LOOKS` of every step (n, 1 + 9 steps) as (n, steps, 10), from each begin on."""
    inner = at[:, 1:].reshape(len(at), -1, len(LOOKS))
    begin = np.concatenate([at[:, :1], inner[:, :-1, -1]], axis=1)[:, :, None]
    return np.concatenate([begin, inner], axis=2)
