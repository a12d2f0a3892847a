"""Laws over the time: loads, motions and roads, at whose corners, jumps and short pulses steps end.

An error estimate sees what happens at the few times of a step: a pulse that begins and ends between them is missed,
whatever the tolerance. So laws over the time are looked at once, before a run. The points of tables are known. Corners
of formulas are where the argument of a step function changes sign. Between these a run is divided into parts in which a
law is nearly a cubic, and steps end where short parts do. To find short pulses, laws are sampled at equal distances,
and densely around the zeros of their intermediate results: around t = m in exp(-(t - m)²/w²).
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from functools import cache, lru_cache
from typing import Any, NamedTuple, Protocol

import numpy as np

from ...._jit.formulas.differentiate import jacobian
from ...._jit.formulas.expression import Expression, Graph
from ...._jit.formulas.program import program
from ...._jit.formulas.replay import needed, replay
from ....algebra import Array
from ....elements import OPERATORS
from ....elements.recorder import Variant, record
from ....model import Curve, Formula, Surface
from ....system import System
from ....system.cached import once
from ....system.curves.curve_derivatives import MANY, formula_graph, steps_in
from ....system.structure.population import Population

FIXED, OF_TIME, MOVES = range(3)  # what a recorded number depends on: numbers, the time too, or the state
SAMPLES = 2**13 + 1  # of a law over a run
NEARLY = 0.01  # of the range of a law: how far it may be from a cubic within a part
SHARES = np.linspace(0, 1, 22)  # of a part, where that is examined; at every seventh the cubic meets the law
CUBIC = np.linalg.inv(SHARES[::7, None] ** np.arange(4))
PARTS = (
    400  # of a run, besides those between corners: a law with more varies all the time, and bounds all steps
)
ROUND = 1e-12  # [-] of the end time, below which two times to stop at are the same; also of other ranges
ASIDE = 1e-14  # [-] of the end time: so far before a jump steps end, and behind it they begin
ROUND_OFF = 1e-9  # [-] of the greatest value of a table, which its points miss by less


class ExaminedLaw(Hashable, Protocol):
    """A law that can be divided into parts; equal laws are examined once."""

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
    """

    def __init__(
        self, key: Hashable, graph: Graph, value: Expression, variable: str, numbers: Mapping[Any, float]
    ) -> None:
        self._key, self._graph, self._value, self._variable, self._numbers = (
            key,
            graph,
            value,
            variable,
            numbers,
        )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Law) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    def __call__(self, t: Array, order: int = 0) -> Array:
        """Its values, or its derivatives of an order (nt,)."""
        value: Any = self._value
        for _ in range(order):
            ((value,),) = jacobian(self._graph, [value], [self._graph.input(self._variable)])
        return self._of([value], t)[0]

    def _of(self, wanted: list[Any], t: Array) -> list[Array]:
        """Intermediate results, each (nt,)."""
        with np.errstate(all="ignore"):
            found = replay(self._graph, wanted, {**self._numbers, (self._variable,): t}, MANY)
        return [np.broadcast_to(np.asarray(value, dtype=float), t.shape) for value in found]

    def zeros(self, t: Array) -> tuple[Array, Array]:
        """Times at which arguments of step functions change sign, and those at which other results do."""
        graph, steps = self._graph, {one.id: one for one in steps_in(self._graph, [self._value])}
        order = needed(graph, [self._value])
        inner = {n: Expression(graph, n) for n in order if graph.nodes[n].op != "constant"} | steps
        corners, others = [np.zeros(0)], [np.zeros(0)]
        for (n, one), value in zip(inner.items(), self._of([*inner.values()], t), strict=True):
            at = np.flatnonzero(np.diff(value > 0))
            if len(at) and (n in steps or len(at) <= PARTS):
                (corners if n in steps else others).append(self._bisected(one, t[at], t[at + 1]))
        return np.concatenate(corners), np.concatenate(others)

    def _bisected(self, one: Expression, low: Array, high: Array) -> Array:
        """Return where a result changes sign between two times (n,): the first number behind."""
        above = self._of([one], low)[0] > 0
        middle = 0.5 * (low + high)
        while np.any((middle > low) & (middle < high)):
            same = (self._of([one], middle)[0] > 0) == above
            low, high = np.where(same, middle, low), np.where(same, high, middle)
            middle = 0.5 * (low + high)
        return high


class Parts(NamedTuple):
    """Corners of a law, rising ends of parts in which it is nearly a cubic, not all of too many, and its range."""

    corners: Array
    ends: Array
    spread: float

    @property
    def too_many(self) -> bool:
        """Whether the law varies all the time."""
        return len(self.ends) > PARTS + len(self.corners)


@lru_cache
def parts_of(law: ExaminedLaw, begin: float, until: float) -> Parts:
    """The parts of a law between two arguments."""
    even = np.linspace(begin, until, SAMPLES)
    corners, others = law.zeros(even)
    near = (until - begin) * 0.5 ** np.arange(1, -np.log2(ROUND))
    dense = np.concatenate([corners, others])[:PARTS, None] + np.concatenate([-near, near])
    t = np.unique(np.concatenate([even, corners, others, dense.ravel()]))
    t = t[(t >= begin) & (t <= until)]
    values = law(t)
    known = np.isfinite(values)  # others are no arguments, as negative squares of lengths
    if not known.any():
        return Parts(corners, np.zeros(0), 0.0)
    t, values = t[known], values[known]
    corners = corners[(corners >= t[0]) & (corners <= t[-1])]
    ends, spread = np.unique([t[0], *corners, t[-1]]), float(np.ptp(values))
    if spread > ROUND * abs(values).max():
        ends = _divided(law, t, values, NEARLY * spread, ends)
    return Parts(corners, ends, spread)


def _divided(law: ExaminedLaw, t: Array, values: Array, tolerance: float, ends: Array) -> Array:
    """Ends of parts in each of which the law is nearly a cubic; as many as show that there are too many."""
    low, high, least, most = ends[:-1], ends[1:], ROUND * (ends[-1] - ends[0]), PARTS + len(ends)
    while len(low) and len(ends) <= most:
        divided = (high - low > least) & ~_are_cubic(law, t, values, tolerance, low, high)
        middle = 0.5 * (low + high)[divided]
        low, high = np.sort(np.append(low[divided], middle)), np.sort(np.append(high[divided], middle))
        ends = np.append(ends, middle)
    return np.sort(ends)


def _are_cubic(law: ExaminedLaw, t: Array, values: Array, tolerance: float, low: Array, high: Array) -> Array:
    """Whether a law is within a tolerance of its cubic in parts (n,), up to the last number before their ends."""
    last = np.nextafter(high, low)
    own = law(np.minimum(low[:, None] + (last - low)[:, None] * SHARES, last[:, None]).ravel()).reshape(
        len(low), -1
    )
    part = np.maximum(np.searchsorted(low, t, side="right") - 1, 0)
    with np.errstate(all="ignore"):  # poles, and parts of a single number
        cubics = own[:, ::7] @ CUBIC.T
        far = np.any(abs(own - cubics @ (SHARES[:, None] ** np.arange(4)).T) > tolerance, axis=1)
        share = (t - low[part]) / (last - low)[part]
        fitted = np.einsum("nk,nk->n", cubics[part], share[:, None] ** np.arange(4))
    far[part[(share >= 0) & (share <= 1) & (abs(values - fitted) > tolerance)]] = True
    return np.asarray(~far)


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
    found = [_features_of(law, begin, until) for law in _laws(system)]
    corners, ends = (np.unique(np.concatenate([np.zeros(0), *(f[n] for f in found)])) for n in range(2))
    return Features(corners, ends, min((f.longest for f in found), default=np.inf))


def _features_of(law: Law, begin: float, until: float) -> Features:
    """Those of one law: ends of parts that are shorter than half of the longest one."""
    parts, none = parts_of(law, begin, until), np.zeros(0)
    if parts.too_many:
        rates = abs(law(np.linspace(begin, until, SAMPLES), 1))
        return Features(parts.corners, none, parts.spread / float(rates[np.isfinite(rates)].max()))
    lengths = np.diff(parts.ends)
    if len(lengths) < 2:
        return Features(parts.corners, none, np.inf)
    short = 2 * lengths < lengths.max()
    ends = np.concatenate([parts.ends[:-1][short], parts.ends[1:][short]])
    return Features(parts.corners, np.setdiff1d(ends, parts.corners), float(lengths.max()))


@once
def _laws(system: System) -> tuple[Law, ...]:
    """The laws over the time but tables, each once."""
    return tuple({law: None for p in system.populations if p.count for law in _of(p)})


def _of(p: Population) -> Iterator[Law]:
    """Formulas of a kind of element, and what its own Q or Phi computes from the time alone."""
    fields = fields_of_time(p.variant)
    graph, own = expressions_of_time(p.variant)
    for values in p.values:
        for formula in (values[n] for n in fields if isinstance(values[n], Formula)):
            yield formula_law(formula)
        if own:
            numbers = np.concatenate([np.ravel(_number(value)) for value in values])
            yield from (_with_numbers(p.variant, graph, value, numbers) for value in own)


def formula_law(formula: Formula) -> Law:
    """A formula of one variable as a law."""
    return Law(program(formula.function), *formula_graph(formula), "x", {})


def _with_numbers(variant: Variant, graph: Graph, value: Expression, numbers: Array) -> Law:
    """An expression of the time in an element with these numbers as a law."""
    inputs = (graph.nodes[n].value for n in needed(graph, [value]) if graph.nodes[n].op == "input")
    used = {name: float(numbers[name[1]]) for name in inputs if name[0] == "numbers"}
    return Law((variant, value.id, *used.items()), graph, value, "t", used)


def _number(value: Any) -> Any:
    """A curve or a surface has the place of one number."""
    return np.nan if isinstance(value, Curve | Formula | Surface) else value


@cache
def fields_of_time(variant: Variant) -> list[int]:
    """Return the fields of an element that are curves over the time."""
    kinds = [kind for kind in variant.kind.fields.values() if kind != "Time"]
    if "Curve" not in kinds or not variant.kind.family:
        return []
    nodes = _recorded(variant).nodes
    called = {
        nodes[node.args[0]].value[1]
        for node in nodes
        if node.op == "curve" and nodes[node.args[1]].value == ("t",)
    }
    fields = zip(variant.kind.widths(), variant.kind.fields.values(), strict=True)
    starts = np.cumsum([0, *(width for width, kind in fields if kind != "Time")])
    return [n for n in range(len(kinds)) if int(starts[n]) in called]


@cache
def expressions_of_time(variant: Variant) -> tuple[Graph, list[Expression]]:
    """The largest expressions of the time and of numbers alone, without curves."""
    if not variant.kind.rows and OPERATORS["Q"] not in variant.kind.family:
        return Graph(), []
    graph = _recorded(variant)
    levels: list[int] = []
    for node in graph.nodes:
        if node.op == "input":
            levels.append({"t": OF_TIME, "numbers": FIXED}.get(node.value[0], MOVES))
        else:
            levels.append(
                MOVES
                if node.op.startswith(("curve", "surface"))
                else max((levels[n] for n in node.args), default=FIXED)
            )
    inner = {
        n for node, level in zip(graph.nodes, levels, strict=True) if level == OF_TIME for n in node.args
    }
    own = [n for n, level in enumerate(levels) if level == OF_TIME and n not in inner and graph.nodes[n].args]
    return graph, [Expression(graph, n) for n in own]


def _recorded(variant: Variant) -> Graph:
    return record(variant, ("Phi",) if variant.kind.rows else ("Q",)).graph


class Stops(NamedTuple):
    """Times at which steps end.

    Attributes
    ----------
    all : of all of them
    kinks : those after which a method starts anew
    longest : step between them
    aside : how far kinks are before the times of jumps, so that all stages of a step are on one side
    behind : how long after the start the first step begins, behind a jump there
    """

    all: Array
    kinks: Array
    longest: float
    aside: float
    behind: float


def stops_of(
    system: System, given: Array, until: float, begin: float = 0.0, *, step: float | None = None
) -> Stops:
    """Times at which steps end; where a step is given, at corners only."""
    if given.ndim != 1 or not np.all(np.isfinite(given)):
        raise ValueError("breakpoints must be finite numbers. Give a list of times in s.")
    every, ends, own = points_of_tables(system, begin, until)
    corners, soft, longest = features(system, begin, until)
    aside = ASIDE * max(abs(begin), abs(until))
    jumps = np.concatenate([given, corners, own]) - aside
    stops, kinks = (np.concatenate([jumps, times]) for times in (every, ends))
    if step is not None:
        longest = np.inf
    else:
        stops = np.concatenate([stops, soft])
    late = jumps + aside - begin
    behind = max((x + 2 * aside for x in late[abs(late) <= ROUND * max(abs(begin), abs(until))]), default=0.0)
    return Stops(_apart(stops, begin, until), _apart(kinks, begin, until), longest, aside, behind)


def points_of_tables(system: System, begin: float, until: float) -> tuple[Array, Array, Array]:
    """Rising times of the points of all tables over time; those where second derivatives jump, and where values do.

    A table is a cubic spline, twice continuously differentiable at its inner points, and straight beyond its ends, or
    periodic. Cubics that a user gives may be any.
    """
    if not (curves := _curves_of_time(system)):
        return (np.zeros(0),) * 3
    every = [
        x for curve in curves for x in curve.knots_within(begin, until)[1:-1]
    ]  # the outer segments are straight
    single = [curve for curve in curves if len(curve.knots) > 3 and not curve.periodic]
    ends = [x for curve in single for x in (curve.knots[1], curve.knots[-2])]
    jumps = [x for curve in curves for x in _jumps(curve)]
    return np.unique(np.array(every)), np.unique(np.array(ends)), np.unique(np.array(jumps))


def _jumps(curve: Curve) -> Iterator[float]:
    """The points at which the values of two cubics differ by more than round-off."""
    x, after = np.array(curve.knots), np.array([cubic[3] for cubic in curve.cubics])
    ends = [np.polyval(cubic, width) for cubic, width in zip(curve.cubics, np.diff(x), strict=True)]
    yield from x[1:-1][abs(after[1:] - ends[:-1]) > ROUND_OFF * abs(after).max()].tolist()


def _apart(times: Array, begin: float, until: float) -> Array:
    """The times inside of the run, without those that differ from the one before by round-off alone."""
    if not len(times):
        return times
    least = ROUND * max(abs(begin), abs(until))
    times = np.unique(times)
    inside = times[(times > begin + least) & (times < until - least)]
    return inside[np.diff(inside, prepend=-np.inf) > least]


@once
def _curves_of_time(system: System) -> list[Curve]:
    laws = (
        values[n]
        for p in system.populations
        for values in p.values
        for n in (fields_of_time(p.variant) if p.count else ())
    )
    return [one for one in laws if isinstance(one, Curve) and (len(one.cubics) > 1 or one.periodic)]
