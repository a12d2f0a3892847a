"""The designs that a solver has asked for: scaled variables, the last point kept, the best one, the history."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ...algebra import Array
from ...model.show import suggest
from .study import Point, Study

Bounds = Mapping[str, tuple[float | None, float | None]]
Progress = Callable[[int, float], None]


class Search:
    """From a solver's variables z = x / scale to designs.

    Parameters
    ----------
    study : Study
    bounds : lower and upper limits by name, None for none
    progress : called with the number of the evaluation and the objective
    """

    def __init__(self, study: Study, bounds: Bounds | None, progress: Progress | None) -> None:
        self.point = self.first = study.start()
        self.names = self.point.parameters.names
        self._refuse_unknown(bounds or {})
        self.limits = np.array(
            [_limit((bounds or {}).get(name, (None, None))) for name in self.names]
        ).reshape(-1, 2)
        self.x0 = self.point.parameters.values
        self.scale = _scales(self.x0, self.limits)
        self.history: list[tuple[float, float]] = []
        self.trace: list[Array] = []
        self._progress = progress

    def _refuse_unknown(self, bounds: Bounds) -> None:
        for name in bounds:
            if name not in self.names:
                raise ValueError(
                    f"bounds for {name!r}, which is no design variable; {suggest(name, self.names)}"
                )

    def at(self, z: Array) -> Point:
        """The design of a solver's variables; simulated once."""
        x = np.asarray(z) * self.scale
        if not np.array_equal(x, self.point.parameters.values):
            self.point = self.first if np.array_equal(x, self.x0) else self.first.at(x)
        return self.point

    def note(self, point: Point, value: float, slope: Array) -> None:
        """Write an evaluation down."""
        self.history.append((value, float(np.linalg.norm(slope * self.scale))))
        self.trace.append(point.parameters.values.copy())
        if self._progress:
            self._progress(len(self.history), value)

    @property
    def scaled_limits(self) -> Sequence[tuple[float, float]]:
        """Bounds of the solver's variables."""
        return [(low, high) for low, high in self.limits / self.scale[:, None]]


def _limit(given: tuple[float | None, float | None]) -> tuple[float, float]:
    low, high = given
    return -np.inf if low is None else float(low), np.inf if high is None else float(high)


def _scales(x: Array, limits: Array) -> Array:
    """The size of each variable: its value, or half its range, or 1."""
    width = np.where(np.all(np.isfinite(limits), axis=1), (limits[:, 1] - limits[:, 0]) / 2, 1.0)
    return np.where(x != 0, abs(x), width)
