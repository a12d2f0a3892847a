"""Random changes of the parameters, by which the size of errors of derivatives is estimated."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np

from .....algebra import Array
from .....results import Assembly
from ....equations.length import extent
from ...chain.chain import Gradients
from ...parameters.parameters import Parameters
from ..unresolved_modes import DRAWN

# The first of these changes sees 0.2 and more of the effects of each of two to four parameters, and of each pair
SEED = 97
TINY = float(np.finfo(float).tiny)
Directions: TypeAlias = tuple[Array, Array, Array, Array]  # changes of b, q₀, v₀ and c, see `Chain.along`
# Whether relative errors of derivatives (k,) by a number of first changes suffice
Enough: TypeAlias = Callable[[Array, int], bool]


@dataclass(frozen=True, eq=False)
class RandomChanges:
    """Changes of the parameters, whose effects on a response have squares with about the sum of those of all.

    Attributes
    ----------
    parameters : what changes
    weights : (p,) of comparable changes
    each : (n, p), orthogonal; for up to `DRAWN` parameters the squares have exactly this sum, and of more it is below a
        third of it in 2 % of cases
    """

    parameters: Parameters
    weights: Array
    each: Array

    @classmethod
    def of(
        cls, parameters: Parameters, found: Array, start: Assembly, until: float, hidden: Array | None = None
    ) -> RandomChanges:
        """Of the parameters that derivatives (k, p) are by, of a run from a start to a time; see `comparable`."""
        weights = comparable(parameters, found, start, until, hidden)
        felt = np.flatnonzero(weights)
        drawn = np.zeros((min(max(len(felt), 1), DRAWN), len(weights)))
        drawn[: len(felt), felt] = orthogonal(len(felt))
        return cls(parameters, weights, weights * drawn)

    @cached_property
    def hidden(self) -> bool:
        """Whether laws change of which the motion shows nothing."""
        return bool(self.weights[self.parameters.hidden].any())

    @cached_property
    def directions(self) -> Directions:
        """The changes of the numbers and of the guess of the assembly, as `Chain.along` takes them."""
        return self.parameters.along(self.each.T)

    def first_relative(self, errors: Iterable[Array], found: Array, enough: Enough) -> Array:
        """Relative errors of derivatives (k, p) by those of the changes of responses (k,), by as many as is enough."""
        first, relative = list[Array](), np.zeros(len(found))
        for own in errors:
            first.append(own)
            relative = self.relative(np.array(first), found)
            if enough(relative, len(first)):
                break
        return relative

    def relative(self, errors: Array, found: Array) -> Array:
        """Relative errors of derivatives (k, p) by those of the changes of responses with the first changes (n, k)."""
        error = np.linalg.norm(errors, axis=0) * np.sqrt(len(self.each) / len(errors))
        sizes = np.linalg.norm(found * self.weights, axis=1)
        return np.asarray(np.divide(error, sizes, out=np.zeros_like(sizes), where=sizes > 0))


def orthogonal(p: int) -> Array:
    """Orthogonal changes of p parameters (n, p), each with the same part of all of them.

    They are no mere signs, as the changes of a length and of its end may cancel each other.
    """
    drawn = np.linalg.qr(np.random.default_rng(SEED).standard_normal((p, min(p, DRAWN))))[0].T
    return np.asarray(drawn / np.linalg.norm(drawn, axis=0))


def without_curves(parameters: Parameters, weights: Array) -> Array:
    """Zero (p,) for parameters in tables or formulas, whose derivatives at moved steps are by the own curves."""
    system = parameters.system
    by_b, none = np.zeros((len(system.b), 1)), np.zeros((system.nq, 1))
    by_b[system.nb :, 0] = np.random.default_rng(2).standard_normal(len(system.b) - system.nb)
    by = parameters.gradient(Gradients(by_b, none, none), np.zeros((parameters.c_size, 1)))
    return np.where(by[:, 0] != 0.0, 0.0, weights)


def comparable(
    parameters: Parameters, found: Array, start: Assembly, until: float, hidden: Array | None = None
) -> Array:
    """How much parameters may change (p,): by their value; zero lengths by that of the mechanism, others if alone.

    This is in proportion only: the largest effect on a response is one, as squares of tiny values would vanish. Zero
    constants of laws have this effect, too, if they are in `hidden` (p,), and none otherwise.
    """
    length = extent(parameters.system, start.q)
    sizes = {"m": length, "m/s": length / (until - start.t)}
    weights = np.array(
        [abs(x) or sizes.get(unit, 0.0) for x, unit in zip(parameters.values, parameters.units, strict=True)]
    )
    felt = abs(found).max(axis=0, initial=0.0)
    most = (weights * felt).max(initial=0.0)
    largest = _of_units(parameters.units, felt)
    alone = np.divide(felt > 0, largest, out=0.0 * felt, where=largest > TINY)
    weights = np.where(felt > 0, weights / most, 0.0) if most > TINY else alone
    if hidden is None:
        return weights
    return np.where(parameters.hidden & (parameters.values == 0.0), np.where(hidden, alone, 0.0), weights)


def _of_units(units: Sequence[str], felt: Array) -> Array:
    """The largest effects (p,) of all parameters of the same unit, if it is known."""
    found = {unit: max(x for x, own in zip(felt, units, strict=True) if own == unit) for unit in {*units}}
    return np.array([found[unit] if unit else x for x, unit in zip(felt, units, strict=True)])
