"""The cases of a study: all combinations, space-filling samples, random ones, or listed ones."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from math import prod
from typing import Any, ClassVar

import numpy as np

from ..model import SarrusError
from ..model.show import suggest
from .parameters import Array, Parameter, number, whole


@dataclass(frozen=True)
class Sample(ABC):
    """A way to choose cases."""

    kind: ClassVar[str]

    @abstractmethod
    def cases(self, parameters: Mapping[str, Parameter]) -> Array:
        """The values of all parameters in every case (n, p)."""

    def described(self) -> dict[str, Any]:
        """The form in a study file."""
        return {"type": self.kind, **asdict(self)}


MOST = 1_000_000  # cases


def _refuse_many(cases: int) -> None:
    if cases > MOST:
        raise SarrusError(f"a study has at most {MOST:,} cases, but these are {cases:,}. Take fewer values.")


@dataclass(frozen=True)
class Grid(Sample):
    """All combinations of the parameters' values; the last parameter changes fastest."""

    kind = "grid"

    def cases(self, parameters: Mapping[str, Parameter]) -> Array:
        values = [parameter.grid() for parameter in parameters.values()]
        _refuse_many(prod(len(parameter) for parameter in values))
        rows = list(product(*values))
        return np.array(rows, dtype=float).reshape(len(rows), len(parameters))


@dataclass(frozen=True)
class Spread(Sample):
    """`count` cases from points in the unit cube; the same `seed` gives the same cases."""

    count: int
    seed: int = 0

    def __post_init__(self) -> None:
        _refuse_many(whole(self.count, "the count of a sample"))
        whole(self.seed, "a seed", 0)

    @abstractmethod
    def points(self, width: int) -> Array:
        """Points in the unit cube (count, width)."""

    def cases(self, parameters: Mapping[str, Parameter]) -> Array:
        """Every parameter at its column of the points."""
        u = self.points(len(parameters))
        columns = [parameter.at(u[:, k]) for k, parameter in enumerate(parameters.values())]
        return np.column_stack(columns) if columns else np.zeros((self.count, 0))


@dataclass(frozen=True)
class LatinHypercube(Spread):
    """Latin hypercube sample: every parameter once in each of `count` equally probable intervals.

    The same `seed` gives the same cases.
    """

    kind = "latin_hypercube"

    def points(self, width: int) -> Array:
        """SciPy's Latin hypercube."""
        from scipy.stats import qmc

        return np.asarray(qmc.LatinHypercube(width, seed=np.random.default_rng(self.seed)).random(self.count))


@dataclass(frozen=True)
class Sobol(Spread):
    """A scrambled Sobol sequence: means converge faster than those of random samples.

    The `count` of cases is a power of two; the same `seed` gives the same cases.
    """

    kind = "sobol"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.count & (self.count - 1):
            nearest = 2 ** round(float(np.log2(self.count)))
            raise SarrusError(f"a Sobol sample has a power of 2 cases, not {self.count}. Take {nearest}.")

    def points(self, width: int) -> Array:
        """SciPy's Sobol sequence."""
        from scipy.stats import qmc

        sequence = qmc.Sobol(width, seed=np.random.default_rng(self.seed))
        return np.asarray(sequence.random_base2(self.count.bit_length() - 1))


@dataclass(frozen=True)
class MonteCarlo(Spread):
    """A number `count` of independent random cases; the same `seed` gives the same ones."""

    kind = "monte_carlo"

    def points(self, width: int) -> Array:
        """Random numbers of NumPy's generator PCG64."""
        return np.random.default_rng(self.seed).random((self.count, width))


@dataclass(frozen=True)
class Listed(Sample):
    """Given cases: each of the `rows` has one value for every parameter, in the order of the parameters."""

    kind = "listed"
    rows: tuple[tuple[float, ...], ...]

    def cases(self, parameters: Mapping[str, Parameter]) -> Array:
        if any(len(row) != len(parameters) for row in self.rows):
            raise SarrusError(f"every listed case needs {len(parameters)} numbers: {', '.join(parameters)}")
        return np.array(self.rows, dtype=float).reshape(len(self.rows), len(parameters))


SPREADS: dict[str, type[Spread]] = {one.kind: one for one in (LatinHypercube, Sobol, MonteCarlo)}


def sample_of(sample: Any) -> Sample:
    """A sample of what a user writes for one: ``{"type": "sobol", "count": 64, "seed": 1}``, or nothing for a grid.

    Raises
    ------
    SarrusError
        For anything else.
    """
    if isinstance(sample, Sample):
        return sample
    options = {"type": sample or "grid"} if sample is None or isinstance(sample, str) else sample
    if not isinstance(options, Mapping):
        raise SarrusError(f"a sample is a mapping with a type, but is {sample!r}. Give one as in Sobol(64).")
    entries = {str(key): value for key, value in options.items()}
    kind = entries.pop("type", "grid")
    return _made(str(kind), entries)


def _made(kind: str, entries: dict[str, Any]) -> Sample:
    known = {"grid": set[str](), "listed": {"rows"}} | {name: {"count", "seed"} for name in SPREADS}
    if kind not in known:
        raise SarrusError(f"there is no sample {kind!r}. {suggest(kind, known)}")
    if entries.keys() - known[kind]:
        wrong = sorted(entries.keys() - known[kind])[0]
        raise SarrusError(
            f"the sample {kind} has no key {wrong!r}. Choose from {', '.join(sorted(known[kind])) or 'none'}."
        )
    if kind in SPREADS:
        if "count" not in entries:
            raise SarrusError(f"the sample {kind} needs a count. Give the number of cases.")
        seed = whole(entries.get("seed", 0), "a seed", 0)
        return SPREADS[kind](whole(entries["count"], "the count of a sample"), seed)
    return Listed(_rows(entries.get("rows", ()))) if kind == "listed" else Grid()


def _rows(rows: Any) -> tuple[tuple[float, ...], ...]:
    if not isinstance(rows, Sequence) or not all(isinstance(row, Sequence) for row in rows):
        raise SarrusError("the sample listed needs rows of numbers, one for each parameter.")
    return tuple(tuple(number(value) for value in row) for row in rows)
