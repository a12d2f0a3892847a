"""Location of short features in loads, motions and roads that depend on time, at which steps must end.

An error estimate sees what happens at the few times of a step: a pulse that begins and ends between them is missed,
whatever the tolerance. So laws over the time are examined before a run. Their corners are where the argument of a step
function changes sign. Between these a run is divided into parts in which every law is nearly a cubic, and steps end
where short parts do. To find short features, laws are sampled at equal distances, and densely around the zeros of
their intermediate results: around t = m in exp(-(t - m)²/w²).
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from functools import lru_cache
from itertools import compress
from typing import Any, NamedTuple, Protocol

import numpy as np

from ...._jit.formulas.expression import Expression, Graph
from ...._jit.formulas.program import program
from ...._jit.formulas.replay import needed
from ....algebra import Array
from ....elements.recorder import Variant
from ....model import Curve, Formula
from ....system import System
from ....system.cached import once
from ....system.curves.curve_derivatives import MANY, by_constants, evaluated, formula_graph, steps_in
from ....system.structure.population import Population
from .laws_of_time import expressions_of_time, fields_of_time, slopes_of_time

SAMPLES = 2**13 + 1  # of a law over a run
FEW = 64  # zeros of an intermediate result around which a law is sampled densely; where it oscillates it has more
HALVINGS = 40  # of the distance from such a zero, so that features of 1e-12 of a run are seen
BISECTIONS = 60  # of an interval with a corner, to round-off
NEARLY = 0.01  # of the range of a law: how far it may be from a cubic within a part
SHARES = np.linspace(0, 1, 22)  # of a part, where that is examined
FITTED = [0, 7, 14, 21]  # of them, where the cubic meets the law
CUBIC = np.linalg.inv(SHARES[FITTED][:, None] ** np.arange(4))
# Of a run, besides those between corners; a law with more varies all the time, and bounds all steps
PARTS = 400
HIDDEN = 0.25  # of the longest step that a law bounds: its derivatives alone choose no shorter ones
SHORT = 4  # times that a part is shorter than the longest one where steps end with it
AHEAD = 1e-9  # of a run: distance of two times that give the rate of a law that varies all the time
KNOWN = 256  # laws whose features are stored
LEAST = 1e-12  # of a run: parts that are not divided; of the size of a law: a range that is round-off


class Features(NamedTuple):
    """Times and lengths of short features of laws.

    Attributes
    ----------
    corners : times of corners and jumps
    ends : times of other ends of short parts
    longest : step that passes over no part in which a law varies
    """

    corners: Array
    ends: Array
    longest: float


def features(system: System, begin: float, until: float) -> Features:
    """The features of all laws over the time that are formulas or Python functions; tables have their points."""
    laws = _laws(system)
    found = [features_of(law, begin, until) for law in laws]
    corners, ends = (np.unique(np.concatenate([np.zeros(0), *(f[n] for f in found)])) for n in range(2))
    longest = [(HIDDEN if law.hidden else 1.0) * f.longest for law, f in zip(laws, found, strict=True)]
    return Features(corners, ends, min(longest, default=np.inf))


class Examined(Hashable, Protocol):
    """A law that can be examined; equal laws are examined once."""

    def __call__(self, x: Array) -> Array:
        """Its values (n,)."""

    def zeros(self, x: Array) -> tuple[Array, Array]:
        """Arguments at which it has corners, and others around which it is looked at closely."""


class Law:
    """A function of the time; two are equal if they do the same.

    Parameters
    ----------
    key : identifies it among others
    graph, value : where it is recorded
    variable : the input that is the time
    numbers : values of other inputs
    hidden : whether the error of steps does not depend on it, only that of derivatives
    """

    def __init__(
        self, key: Hashable, graph: Graph, value: Expression, variable: str, numbers: Mapping[Any, float],
        hidden: bool = False,
    ) -> None:  # fmt: skip
        self.hidden = hidden
        self._key, self._graph, self._value = key, graph, value
        self._variable, self._numbers = variable, numbers
        self._orders: dict[int, list[int]] = {}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Law) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    def __call__(self, t: Array) -> Array:
        """Its values (nt,)."""
        return self._of(self._value, t)

    def _of(self, result: Expression, t: Array) -> Array:
        """An intermediate result (nt,)."""
        with np.errstate(all="ignore"):
            value = evaluated(self._graph, [result], self._inputs(t), MANY, self._order(result.id))[0]
        return np.broadcast_to(np.asarray(value, dtype=float), t.shape)

    def _inputs(self, t: Array) -> dict[Any, Any]:
        return {**self._numbers, (self._variable,): t}

    def _order(self, identity: int) -> list[int]:
        if identity not in self._orders:
            self._orders[identity] = needed(self._graph, [Expression(self._graph, identity)])
        return self._orders[identity]

    def zeros(self, t: Array) -> tuple[Array, Array]:
        """Times at which arguments of step functions change sign, and those at which other results do."""
        nodes = self._graph.nodes
        inner = [Expression(self._graph, n) for n in self._order(self._value.id) if nodes[n].op != "constant"]
        steps = {one.id: one for one in steps_in(self._graph, [self._value])}
        inner = list(({one.id: one for one in inner} | steps).values())
        with np.errstate(all="ignore"):
            found = evaluated(self._graph, inner, self._inputs(t), MANY)
        corners, others = [np.zeros(0)], [np.zeros(0)]
        for one, value in zip(inner, found, strict=True):
            above = np.broadcast_to(np.asarray(value > 0), t.shape)
            at = np.flatnonzero(above[1:] != above[:-1])
            if len(at) and (one.id in steps or len(at) <= FEW):
                where = corners if one.id in steps else others
                where.append(self._bisected(one, t[at], t[at + 1], above[at]))
        return np.concatenate(corners), np.concatenate(others)

    def _bisected(self, one: Expression, low: Array, high: Array, above: Array) -> Array:
        """Return where a result changes sign between two times (n,)."""
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            same = (self._of(one, middle) > 0) == above
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        return high


@once
def _laws(system: System) -> tuple[Law, ...]:
    """The laws over the time, each once."""
    return tuple({law: None for p in system.populations if p.count for law in _of(p)})


def _of(p: Population) -> Iterator[Law]:
    """Formulas of a kind of element, and what its own Q or Phi computes from the time alone."""
    fields = fields_of_time(p.variant)
    graph, own = expressions_of_time(p.variant)
    for values in p.values:
        for formula in (values[n] for n in fields if isinstance(values[n], Formula)):
            yield formula_law(formula)
            yield from _hidden(formula)
        if own:
            numbers = numbers_of(values)
            yield from (_with_numbers(p.variant, graph, value, numbers) for value in own)
            if 0.0 in numbers:
                with_slopes, slopes = slopes_of_time(p.variant)
                for value in (slope for place, slope in slopes if numbers[place] == 0.0):
                    yield _with_numbers(p.variant, with_slopes, value, numbers, hidden=True)


def formula_law(formula: Formula, hidden: bool = False) -> Law:
    """A formula of one variable as a law."""
    steps = program(formula.function)
    return Law((steps, hidden), *formula_graph(formula), "x", {}, hidden)


def _with_numbers(
    variant: Variant, graph: Graph, value: Expression, numbers: Array, hidden: bool = False
) -> Law:
    """An expression of the time in an element with these numbers as a law."""
    inputs = (graph.nodes[n].value for n in needed(graph, [value]) if graph.nodes[n].op == "input")
    used = {name: float(numbers[name[1]]) for name in inputs if name[0] == "numbers"}
    return Law((variant, value.id, hidden, *used.items()), graph, value, "t", used, hidden)


def _hidden(formula: Formula) -> Iterator[Law]:
    """Derivatives of a formula by its factors that are zero, such as an amplitude: it does not show what they do.

    Derivatives by them have no digit if steps are longer than that.
    """
    written = formula.written
    hidden = written.hidden() if written else []
    if any(hidden):  # otherwise nothing is differentiated
        for slope in compress(by_constants(written), hidden):
            yield formula_law(Formula(slope), hidden=True)


def numbers_of(values: tuple[Any, ...]) -> Array:
    """The numbers of an element, in the order in which they are recorded."""
    return np.concatenate([np.ravel(_number(value)) for value in values])


def _number(value: Any) -> Any:
    """A curve has the place of one number."""
    return np.nan if isinstance(value, Curve | Formula) else value


@lru_cache(KNOWN)
def features_of(law: Examined, begin: float, until: float) -> Features:
    """The features of one law between two arguments."""
    span = until - begin
    even = np.linspace(begin, until, SAMPLES)
    corners, others = law.zeros(even)
    near = span * 0.5 ** np.arange(1, HALVINGS + 1)
    dense = np.concatenate([corners, others])[:FEW, None] + np.concatenate([-near, near])
    t = np.unique(np.concatenate([even, dense[(dense > begin) & (dense < until)]]))
    values = law(t)
    finite = np.flatnonzero(np.isfinite(values))
    if not len(finite):
        return Features(corners, np.zeros(0), np.inf)
    known = slice(finite[0], finite[-1] + 1)  # others are no arguments, as negative squares of lengths
    t, values, spread = t[known], values[known], float(np.ptp(values[finite]))
    begin, until = t[[0, -1]].tolist()
    corners = corners[(corners >= begin) & (corners <= until)]
    if spread <= LEAST * np.nanmax(abs(values), initial=0.0):
        return Features(corners, np.zeros(0), np.inf)
    parts = _parts(law, t, values, NEARLY * spread, np.unique([begin, *corners, until]))
    if len(parts) > PARTS + len(corners):
        change = _rises(law, even[:-1], corners, AHEAD * span)
        return Features(corners, np.zeros(0), AHEAD * span * spread / float(np.nanmax(abs(change))))
    lengths = np.diff(parts)
    short = lengths < lengths.max() / SHORT
    ends = np.concatenate([parts[:-1][short], parts[1:][short]])
    longest = float(lengths.max()) if len(lengths) > 1 else np.inf
    return Features(corners, np.setdiff1d(ends, corners), longest)


def _rises(law: Examined, t: Array, corners: Array, ahead: float) -> Array:
    """Return the increase of a law within a short time after given times (n,); NaN over a corner."""
    ends = t + ahead * np.array([[1.0], [2.0]])
    rises = np.diff(law(ends.ravel()).reshape(ends.shape), axis=0)
    rises[np.diff(np.searchsorted(np.sort(corners), ends), axis=0) != 0] = np.nan
    return rises


def _parts(law: Examined, t: Array, values: Array, tolerance: float, between: Array) -> Array:
    """Ends of parts in each of which the law is nearly a cubic; as many as show that there are too many."""
    ends, low, high = between, between[:-1], between[1:]
    least = LEAST * (between[-1] - between[0])
    while len(low) and len(ends) <= PARTS + len(between):
        divided = (high - low > least) & ~_are_cubic(law, t, values, tolerance, low, high)
        middle = 0.5 * (low + high)[divided]
        low, high = np.sort(np.append(low[divided], middle)), np.sort(np.append(high[divided], middle))
        ends = np.append(ends, middle)
    return np.sort(ends)


def _are_cubic(law: Examined, t: Array, values: Array, tolerance: float, low: Array, high: Array) -> Array:
    """Whether a law is within a tolerance of its cubic in parts (n,); their very ends do not count."""
    start, width = low + AHEAD * (high - low), (1 - 2 * AHEAD) * (high - low)
    own = law((start[:, None] + width[:, None] * SHARES).ravel()).reshape(len(low), -1)
    cubics = own[:, FITTED] @ CUBIC.T
    far = np.any(abs(own - cubics @ (SHARES[:, None] ** np.arange(4)).T) > tolerance, axis=1)
    part = np.maximum(np.searchsorted(low, t, side="right") - 1, 0)
    share = (t - start[part]) / width[part]
    fitted = np.einsum("nk,nk->n", cubics[part], share[:, None] ** np.arange(4))
    far[part[(share >= 0) & (share <= 1) & (abs(values - fitted) > tolerance)]] = True
    return np.asarray(~far)
