"""What a problem is, and how far a run is from what is known."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

import sarrus as sr
from sarrus.algebra import Array

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))
from tests.examples.problems import Column  # noqa: E402

KINDS = ("positions", "velocities", "reactions")
ROWS = 201  # times at which a motion is compared


class Known(NamedTuple):
    """What is known of a motion: times (n,), and for each kind of quantity its columns (n, k)."""

    t: Array
    positions: Array
    velocities: Array | None = None
    reactions: Array | None = None


@dataclass(frozen=True)
class Problem:
    """A mechanism, how long it moves, and what is known of its motion.

    Attributes
    ----------
    name : says what is special about it
    make : the system and its start; None is the model's own position
    until : end of the motion [s]
    known : the motion; of the times at which it is wanted, where these are free
    read : the same columns of a run, for each kind: names of outputs, or sums of them
    smooth : whether all forces are smooth functions of the state and of the time
    exact : relative error of what is known
    events : that belong to the mechanism, such as impacts
    """

    name: str
    make: Callable[[], tuple[sr.System, Any]]
    until: float
    known: Callable[[Array], Known]
    read: Mapping[str, Sequence[str | Column]]
    smooth: bool = True
    exact: float = 1e-9
    events: tuple[sr.Event, ...] = ()

    def solution(self) -> Known:
        """What is known, at equally distant times or at those of a table."""
        return self.known(np.linspace(0.0, self.until, ROWS))

    def columns(self, run: sr.Trajectory) -> Known:
        """The same of a run."""
        found = {
            kind: np.stack([column.of(run) for column in map(as_column, own)], axis=1)
            for kind, own in self.read.items()
        }
        return Known(run.t, **found)


def as_column(given: str | Column) -> Column:
    """The column that is an output alone, or that is given."""
    return Column({given: 1.0}) if isinstance(given, str) else given


def errors(found: Known, known: Known) -> dict[str, float]:
    """For each kind the largest error over the size of the motion; nan where nothing is known or the run ended."""
    result = {}
    for kind in KINDS:
        one, other = getattr(found, kind), getattr(known, kind)
        complete = one is not None and other is not None and len(one) == len(other)
        result[kind] = float(abs(one - other).max()) / size(other) if complete else np.nan
    return result


def size(values: Array) -> float:
    """The largest range of all columns; of quantities that are constant their size."""
    spread = float(np.ptp(values, axis=0).max())
    return spread if spread > 1e-9 * float(abs(values).max()) else float(abs(values).max())


def integrated(
    f: Callable[[float, Array], Array],
    y0: Sequence[float],
    t: Array,
    stops: Sequence[float] = (),
    **options: Any,
) -> Array:
    """States (n, k) of y' = f(t, y), by SciPy to round-off; integration begins again at corners of f."""
    settings = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14, **options}
    y, rows = np.array(y0, dtype=float), np.empty((len(t), len(y0)))
    ends = [t[0], *sorted(s for s in stops if t[0] < s < t[-1]), t[-1]]
    for a, b in pairwise(ends):
        mine = (t >= a) & (t <= b)
        done = solve_ivp(f, (a, b), y, t_eval=np.unique([*t[mine], b]), **settings)
        rows[mine] = done.y.T[np.isin(done.t, t[mine])]
        y = done.y[:, -1]
    return rows


def motion(*names: str) -> dict[str, list[str]]:
    """Outputs that are compared: coordinates of bodies or angles of joints, and their rates."""
    parts = [name.rpartition(".") for name in names]
    rates = [f"{part}.velocity.{x}" if x in "xyz" else f"{part}.{x}.rate" for part, _, x in parts]
    return {"positions": [*names], "velocities": rates}


def slide(mass: float, *forces: Any, body: sr.Body | None = None, **given: Any) -> sr.System:
    """A body "mass" that slides along x."""
    body = body or cart(mass)
    guide = sr.Translational("guide", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    return sr.System(sr.Model("slide", [body], [guide], forces, **given))


def cart(mass: float, name: str = "mass", **given: Any) -> sr.Body:
    """A cube whose size goes with its mass as that of steel."""
    side = (mass / 7800) ** (1 / 3)
    return sr.Body(name, mass, (mass * side**2 / 6,) * 3, **given)


def stack(*columns: Array) -> Array:
    """Columns of a table."""
    return np.stack(columns, axis=1)
