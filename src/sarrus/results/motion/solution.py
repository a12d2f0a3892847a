"""A motion at any time: what `simulate(..., store="dense")` gives as `Trajectory.sol`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...model import ModelError
from ...model.checks.arguments import as_numbers

NONE = np.zeros(0)


class NoSolution:
    """In the place of `Trajectory.sol` where the whole motion was not stored: false, and refuses to be called."""

    def __repr__(self) -> str:
        return "NoSolution()"

    def __bool__(self) -> bool:
        return False

    def __call__(self, t: ArrayLike) -> State:
        """Refuse.

        Raises
        ------
        ModelError
        """
        raise ModelError(
            "t: the motion between stored times is not known, and never of a saved run. Simulate with "
            "store='dense', and give the times that are needed later as t_eval."
        )


class State(NamedTuple):
    """A consistent state, from which `simulate` can continue; several states have the times along the first axis.

    Attributes
    ----------
    t : [s]
    q, v, a : (nq,)
    lam : (m,)
    memory : (k,) state variables of elements, such as the angle of a rotational spring with its revolutions
    revolutions : (nc,) revolutions of the joints' angles beyond those nearest to their initial values
    """

    t: float | Array
    q: Array
    v: Array
    a: Array
    lam: Array
    memory: Array = NONE
    revolutions: Array = NONE

    def to_store(self) -> dict[str, Array]:
        """Return the state as arrays of a saved run."""
        return {f"final_{name}": np.asarray(array) for name, array in self._asdict().items()}

    @classmethod
    def stored(cls, arrays: Mapping[str, Array]) -> State | None:
        """Return the state from arrays of a saved run, if there are any."""
        if "final_t" not in arrays:
            return None
        found: dict[str, Any] = {name: arrays[f"final_{name}"] for name in cls._fields}
        return cls(**{**found, "t": float(found["t"])})


class Solution:
    """The motion as a function of time: ``sol(t)`` is the state at one time or at several.

    Between the ends of steps, q is a quintic in t through q, v and a. For HHT and generalized-α, q is a cubic through q
    and v, and v a cubic through v and a. The state is then projected onto the constraints, and its accelerations and
    multipliers solve the equations of motion. At discontinuities of the velocities, the values after them are returned.

    Attributes
    ----------
    t_min, t_max : limits of the time [s]
    """

    def __init__(self, nodes: Any, sampler: Any, revolutions: Any) -> None:
        self._nodes, self._sampler, self._revolutions = nodes, sampler, revolutions
        self.t_min, self.t_max = float(nodes.t[0]), float(nodes.t[-1])
        self._jumps = np.flatnonzero(np.diff(nodes.t) == 0) + 1

    @property
    def times(self) -> Array:
        """The ends of the steps (n,). [s]"""
        return np.asarray(self._nodes.t)

    def __call__(self, t: ArrayLike) -> State:
        """The state at t.

        Raises
        ------
        TypeError
            For times that are no numbers.
        ValueError
            For a time before the start or after the end.
        """
        times = as_numbers(t, lambda: f"t must be one or several times in s, got {t!r:.40}. Give numbers.")
        flat = times.reshape(-1)
        if np.any((flat < self.t_min) | (flat > self.t_max)) or np.any(np.isnan(flat)):
            raise ValueError(
                f"t: the motion is known from t = {self.t_min:g} to {self.t_max:g} s, not at all of {t!r}. "
                "Give times between them."
            )
        order = np.argsort(flat, kind="stable")
        found = [self._between(flat[order], *piece) for piece in self._pieces(flat[order])]
        back = np.argsort(order, kind="stable")
        names = ("q", "v", "a", "lam", "memory")
        every = [np.concatenate([getattr(x, name) for x in found]) for name in names]
        every.append(self._revolutions(flat[order], *every[:2]) if len(flat) else every[-1][:, :0])
        states = [x[back] for x in every]
        return State(times, *states) if times.ndim else State(float(times), *(x[0] for x in states))

    def _pieces(self, times: Array) -> list[tuple[int, int, int, int]]:
        """Between jumps: the first time and the one behind the last, the first node and the one behind the last."""
        cuts = [0, *self._jumps, len(self._nodes.t)]
        ends = [0, *np.searchsorted(times, self._nodes.t[self._jumps], side="left"), len(times)]
        return [(ends[n], ends[n + 1], cuts[n], cuts[n + 1]) for n in range(len(cuts) - 1)]

    def _between(self, times: Array, first: int, last: int, begin: int, end: int) -> Any:
        return self._sampler.states(self._nodes.part(slice(begin, end)), times[first:last])
