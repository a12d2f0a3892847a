"""Derivatives of the equations with respect to the parameters of curves: table values and formula constants.

An operator uses curves by their values and slopes, f⁽ᵒ⁾(x). Its derivative with respect to a parameter c of a curve is
the sum of its exact, recorded derivatives with respect to these calls, times ∂f⁽ᵒ⁾/∂c at x. A parameter of a curve has
a column behind those of all elements: one for each coefficient of a table, and for the constants of a formula one
after another, starting at the index of the curve.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache, lru_cache
from math import perm
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.sparse import csr_array

from ..._jit.formulas.differentiate import jacobian
from ..._jit.formulas.expression import Expression, Graph
from ..._jit.formulas.program import program
from ..._jit.formulas.replay import ARRAYS, needed, replay
from ..._jit.formulas.surfaces import ORDERS as OF_SURFACES
from ...algebra import Array
from ...elements.evaluation import STORED
from ...elements.operators import OPERATORS, Axis
from ...elements.recorder import Variant, record, structure
from ...model import Curve, Formula, Surface
from ...model.laws.curve import Tree
from ...model.laws.jumps import JUMPING
from ..structure.population import Population
from .curve_integrals import Quadrature, law_at

if TYPE_CHECKING:
    from ..system import System

ORDERS = {"curve": 0, "curve_slope": 1, "curve_bend": 2, "curve_twist": 3, "curve_jounce": 4}
ROWS, TIMES = (
    ("lam", "nu", "lam_dot"),
    ("t", "t_dot"),
)  # operands with one entry for each equation; and one alone
MANY: dict[str, Callable[..., Any]] = ARRAYS | {
    "nearest": lambda x: np.floor(x + 0.5),
    "positive": lambda x: np.where(x > 0, 1.0, 0.0),
    **{name: lambda curve, x, order=n: _value(curve, np.atleast_1d(x), order) for name, n in ORDERS.items()},
}  # of arrays over time; of surfaces, `ARRAYS` has them
SIDE_BY_SIDE: dict[str, Callable[..., Any]] = (
    MANY
    | {name: lambda curves, x, order=n: _values(curves, x, order) for name, n in ORDERS.items()}
    | {name: lambda surfaces, x, y, n=n: _heights(surfaces, x, y, n) for name, n in OF_SURFACES.items()}
)  # of arrays over elements and time
KNOWN = 256  # functions of one variable whose derivatives are cached


class Part(NamedTuple):
    """Derivatives of some rows (n,) by parameters, columns (k, nt), at nt times: slopes (n, nt) times basis (k, nt)."""

    rows: Array
    slopes: Array
    columns: Array
    basis: Array


class Integral(NamedTuple):
    """An integral of a curve (nt,), the columns of the parameters it depends on, and its derivatives by each (nt,)."""

    value: Array
    numbers: list[int]
    by: list[Array]


class Entries:
    """Derivatives of an operator by parameters of curves at many times: a sum of parts."""

    def __init__(self, parts: Sequence[Part], times: int) -> None:
        self._parts, self._times = parts, times

    def along(self, db: Array, height: int) -> Array:
        """The change of the operator (nt, height, k) for changes of the parameters (len(b), k)."""
        found = np.zeros((self._times, height, db.shape[1]))
        for rows, slopes, columns, basis in self._parts:
            moved = np.einsum("nt,ntk->tk", basis, db[columns])
            for row, slope in zip(rows, slopes, strict=True):
                found[:, row] += slope[:, None] * moved
        return found

    def gradient(self, weights: Array, size: int) -> Array:
        """The gradient (size, k) of the operator's sum over rows and times with weights (nt, height, k)."""
        found = np.zeros((size, weights.shape[2]))
        for rows, slopes, columns, basis in self._parts:
            for k, by_value in enumerate(np.einsum("nt,tnk->kt", slopes, weights[:, rows])):
                found[:, k] += np.bincount(columns.ravel(), (basis * by_value).ravel(), size)
        return found

    def along_column(self, column: int, moved: Array, height: int) -> Array:
        """The change of the operator (nt, height) where one number changes differently at every time (nt,)."""
        found = np.zeros((self._times, height))
        for rows, slopes, columns, basis in self._parts:
            found[:, rows] += (slopes * np.sum(basis * (columns == column), axis=0) * moved).T
        return found

    def by_column(self, column: int, weights: Array) -> Array:
        """The gradient at every time (nt,) of the operator with weights (nt, height) by one number."""
        found = np.zeros(self._times)
        for rows, slopes, columns, basis in self._parts:
            found += np.sum(basis * (columns == column), axis=0) * np.sum(slopes * weights[:, rows].T, axis=0)
        return found

    def matrix(self, height: int, width: int) -> csr_array:
        """The derivatives at a single time."""
        found = csr_array((height, width))
        for rows, slopes, columns, basis in self._parts:
            values, count = np.outer(slopes, basis).reshape(-1), len(columns)
            places = np.repeat(rows, count), np.tile(columns[:, 0], len(rows))
            found = csr_array(found + csr_array((values, places), shape=(height, width)))
        return found


class _Recipe(NamedTuple):
    """One operator of a variant: its components, its calls of curves, and the derivatives of the components by them.

    places : of the entries: block along the axis, entry of the block
    calls : order, number that holds the place, and argument
    order : of what is evaluated
    """

    graph: Graph
    places: list[tuple[int, int]]
    calls: list[tuple[int, int, Expression]]
    partials: Array
    order: list[int]

    @property
    def wanted(self) -> list[Expression]:
        """The arguments of the calls, and all derivatives."""
        return [*(x for _, _, x in self.calls), *self.partials.flat]


class CurveDerivatives:
    """The derivatives of a system's operators with respect to the parameters of its curves.

    Parameters
    ----------
    system : System
    """

    def __init__(self, system: System) -> None:
        self._system = system
        self._own = [p for p in system.populations if p.count and self.concerns(p)]

    def concerns(self, p: Population) -> bool:
        """Whether elements of a kind have such derivatives."""
        return "Curve" in p.kind.fields.values()

    @property
    def width(self) -> int:
        """Number of columns."""
        return len(self._system.b)

    def __bool__(self) -> bool:
        return bool(self._own)

    def __call__(self, name: str, b: Array, memory: Mapping[int, Any], **operands: Any) -> Entries:
        """The derivatives of an operator.

        Parameters
        ----------
        name : of a vector: "Phi", "Phi_t", "Phi_q_xi", "Phi_qT_lam", "gamma", "Q"
        b : (len(system.b),) numbers
        memory : what elements remembered at each time (nt,), by place in b
        operands : the time ``t`` (nt,), and what the operator takes, as (nt, nq) or (nt, m)
        """
        own = [p for p in self._own if OPERATORS[name] in p.kind.family]
        parts = [part for p in own for part in self._parts(p, name, b, memory, operands)]
        return Entries(parts, len(operands["t"]))

    def matrix(self, name: str, b: Array, t: float, **operands: Array) -> csr_array:
        """The derivatives of an operator at one time, for all columns; operands are (nq,) or (m,)."""
        now = {"t": np.array([t])} | {key: x[None] for key, x in operands.items()}
        height = self._system.m if OPERATORS[name].axes[0] is Axis.ROWS else self._system.nq
        return self(name, b, {}, **now).matrix(height, self.width)

    def of_curve(
        self, p: Population, k: int, place: int, order: int, x: Array
    ) -> tuple[list[Array], list[int], list[list[Array]]]:
        """A derivative f⁽ᵒ⁾ of the curve that is stored in number `place` of an element, at many x (nt,).

        Returns
        -------
        it and its first two derivatives by x; the columns of the curve's numbers that count there; by each of these
        the derivatives of f⁽ᵒ⁾, and those of f⁽ᵒ⁺¹⁾
        """
        curve = stored(p, k, place)
        bases = [self._basis(p, k, place, order + n, x) for n in range(2)]
        numbers = np.unique(bases[0][0]).tolist()
        by = [[np.sum(basis * (at == n), axis=0) for n in numbers] for at, basis in bases]
        return [_value(curve, x, order + n) for n in range(3)], numbers, by

    def integral_of(self, p: Population, k: int, place: int, a: Array, b: Array, power: int) -> Integral:
        """The integral of the curve in number `place` of an element times (x - a)ᵖ, from a to b at many times (nt,)."""
        curve, rule = stored(p, k, place), self._quadrature(p, k, place, a, b)
        arm = rule.arm**power
        columns, basis = self._basis(p, k, place, 0, rule.x)
        numbers = np.unique(columns).tolist()
        by = [rule(np.sum(basis * (columns == n), axis=0) * arm) for n in numbers]
        return Integral(rule(_value(curve, rule.x, 0) * arm), numbers, by)

    def _quadrature(self, p: Population, k: int, place: int, a: Array, b: Array) -> Quadrature:
        return Quadrature(law_at(self._system.b, self._first(p, k, place)), a, b)

    def second_of(self, p: Population, k: int, place: int, order: int, x: Array) -> list[list[Array]]:
        """The second derivatives of f⁽ᵒ⁾(x) (nt,) by the parameters, in the order of `of_curve`; none for a table."""
        curve = stored(p, k, place)
        written = None if isinstance(curve, Curve) else curve.written
        return (
            [[_derivative(f, x, order) for f in row] for row in _by_two_numbers(written)] if written else []
        )

    def second_integral_of(self, p: Population, k: int, place: int, a: Array, b: Array) -> list[list[Array]]:
        """The second derivatives of the integral of the curve times x - a by the parameters (nt,); none for a table."""
        rule = self._quadrature(p, k, place, a, b)
        return [[rule(one * rule.arm) for one in row] for row in self.second_of(p, k, place, 0, rule.x)]

    def _parts(
        self, p: Population, name: str, b: Array, memory: Mapping[int, Any], operands: Any
    ) -> list[Part]:
        """The derivatives of all elements of a population, which are evaluated together."""
        recipe = _recipe(p.variant, name)
        found = values_of_elements(p, recipe.graph, recipe.wanted, recipe.order, b, memory, operands)
        count = len(recipe.calls)
        slopes = found[count:].reshape(*recipe.partials.shape, *found.shape[1:])
        return [
            Part(
                np.array([self._row(p, k, name, *place) for place in recipe.places], dtype=np.int64),
                slopes[:, j, k],
                *self._basis(p, k, place, order, found[j, k]),
            )
            for k in range(p.count)
            for j, (order, place, _) in enumerate(recipe.calls)
        ]

    def _row(self, p: Population, k: int, name: str, block: int, entry: int) -> int:
        """The row of a component of a block."""
        if OPERATORS[name].axes[0] is Axis.ROWS:
            return int(p.rows[k]) + entry
        slot, offset = p.variant.blocks[block]
        return int(p.bodies[k, slot]) + offset + entry

    def _basis(self, p: Population, k: int, place: int, order: int, x: Array) -> tuple[Array, Array]:
        """Columns (parameters, nt) of a curve's parameters, and the derivatives of f⁽ᵒ⁾(x) by them (parameters, nt)."""
        at = self._first(p, k, place)
        curve = stored(p, k, place)
        if isinstance(curve, Curve):
            piece, powers = _powers(curve, x, order)
            return at + 2 + len(curve.cubics) + 4 * piece + np.arange(4)[:, None], powers
        slopes = by_constants(curve.written) if curve.written else []
        columns = np.tile(at + np.arange(len(slopes))[:, None], (1, len(x)))
        return columns, np.array([_derivative(f, x, order) for f in slopes]).reshape(columns.shape)

    def _first(self, p: Population, k: int, place: int) -> int:
        """Return the first index of the parameters of the curve in field `place` of an element."""
        return int(self._system.b[p.at + k * p.kind.size() + place])

    def change_of(self, p: Population, k: int, place: int, db: Array) -> Curve | CurveChange:
        """The change of a curve with its parameters (len(b),): a function of the same argument."""
        at, curve = self._first(p, k, place), stored(p, k, place)
        if isinstance(curve, Curve):
            at += 2 + len(curve.cubics)
            cubics = db[at : at + 4 * len(curve.cubics)].reshape(-1, 4).tolist()
            moved = tuple((a, b, c, d) for a, b, c, d in cubics)
            return replace(curve, cubics=moved, pairs=())
        slopes = by_constants(curve.written) if curve.written else []
        return CurveChange(at, curve.written, tuple(slopes), db[at : at + len(slopes)])

    def by_parameters(
        self, p: Population, k: int, place: int, order: int, x: Array, change: Curve | CurveChange | None
    ) -> tuple[Array, Array]:
        """Columns (parameters, nt), and the derivatives by them of f⁽ᵒ⁾(x), or of its `change` (parameters, nt)."""
        if change is None:
            return self._basis(p, k, place, order, x)
        if isinstance(change, Curve):  # the coefficients of a table are factors
            return np.zeros((0, len(x)), dtype=np.int64), np.zeros((0, len(x)))
        return change.by_parameters(x, order)


def values_of_elements(
    p: Population, graph: Graph, wanted: list[Expression], order: list[int], b: Array,
    memory: Mapping[int, Any], operands: Mapping[str, Any], more: dict[tuple[Any, ...], Any] | None = None,
) -> Array:  # fmt: skip
    """Recorded expressions (wanted, elements, nt) of all elements of a population; `more` are further inputs."""
    inputs, shape = inputs_of(p, b, memory, operands) | (more or {}), (p.count, *operands["t"].shape)
    values = replay(graph, wanted, inputs, SIDE_BY_SIDE, order)
    return np.array([np.broadcast_to(x, shape) for x in values], dtype=float).reshape(len(values), *shape)


def inputs_of(
    p: Population, b: Array, memory: Mapping[int, Any], operands: Mapping[str, Any]
) -> dict[tuple[Any, ...], Any]:
    """The inputs of all elements (elements, nt), or (elements, 1); lists of their curves and surfaces."""
    size, times = p.kind.size(), operands["t"].shape
    own = b[p.at : p.end].reshape(p.count, size)
    inputs: dict[tuple[Any, ...], Any] = {("numbers", n): own[:, n, None] for n in range(size)}
    for place in memory.keys() & range(p.at, p.end):
        k, n = divmod(place - p.at, size)
        whole = np.broadcast_to(inputs["numbers", n], (p.count, *times)).copy()
        whole[k] = memory[place]
        inputs["numbers", n] = whole
    for field in STORED:
        inputs |= {("numbers", n): [values[m] for values in p.values] for m, n in tables_of(p.kind, field)}
    for name, array in operands.items():
        if name in TIMES:
            inputs[name,] = array
        elif name in ROWS:
            inputs |= {(name, n): array.T[p.rows + n] for n in range(p.kind.rows)}
        else:
            bodies = enumerate(zip(p.bodies.T, p.variant.widths, strict=True))
            inputs |= {(name, i, n): array.T[at + n] for i, (at, width) in bodies for n in range(width)}
    return inputs


class CurveChange(NamedTuple):
    """The change of a formula with its constants: the sum of the derivatives by them, with weights.

    first : the column of the first constant
    """

    first: int
    written: Tree | None
    slopes: tuple[Tree, ...]
    weights: Array

    def value(self, x: Array, order: int) -> Array:
        """A derivative of it (nt,)."""
        pairs = zip(self.weights, self.slopes, strict=True)
        return np.asarray(sum((w * _derivative(f, x, order) for w, f in pairs if w), np.zeros(x.shape)))

    def by_parameters(self, x: Array, order: int) -> tuple[Array, Array]:
        """Columns of the constants (constants, nt), and the derivatives of f⁽ᵒ⁾(x) by them (constants, nt)."""
        columns = np.tile(self.first + np.arange(len(self.slopes))[:, None], (1, len(x)))
        rows = _by_two_numbers(self.written) if self.written else []
        return columns, np.array([self._replace(slopes=tuple(row)).value(x, order) for row in rows]).reshape(
            columns.shape
        )


def _powers(curve: Curve, x: Array, order: int) -> tuple[Array, Array]:
    """The interval of each x (nt,), and the factors of its four coefficients in the derivative (4, nt)."""
    knots = np.array(curve.knots)
    x = curve.in_period(x)
    piece = np.searchsorted(knots[1:-1], x, side="right")
    u, powers = x - knots[piece], np.zeros((4, len(x)))
    for n in range(order, 4):
        powers[3 - n] = perm(n, order) * u ** (n - order)
    return piece, powers


def _derivative(function: Callable[[Any], Any], x: Array, order: int) -> Array:
    """A derivative of a recorded function of one variable (nt,)."""
    graph, found, nodes = _recorded(_known(function), order)
    value = replay(graph, [found], {("x",): x}, MANY, nodes)[0]
    return np.broadcast_to(np.asarray(value, dtype=float), x.shape)


class _User:
    """A user's function. Two are equal if they do the same; objects that one refers to may have changed in between."""

    def __init__(self, function: Callable[[Any], Any]) -> None:
        self._function, self._steps = function, program(function)

    def __call__(self, x: Any) -> Any:
        return self._function(x)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _User) and self._steps == other._steps

    def __hash__(self) -> int:
        return hash(self._steps)


@lru_cache(KNOWN)
def _recorded(function: Tree | _User, order: int) -> tuple[Graph, Expression, list[int]]:
    """A derivative of a function of one variable, and the order in which it is evaluated."""
    graph = Graph()
    variable = graph.input("x")
    found = function(variable)
    for _ in range(order):
        found = jacobian(graph, [found], [variable])[0, 0]
    (result,) = graph.expressions([found])
    return graph, result, needed(graph, [found])


@lru_cache(KNOWN)
def by_constants(written: Any) -> list[Any]:
    """The derivatives of a formula with respect to its constants, as functions."""
    return list(written.slopes())


@lru_cache(KNOWN)
def _by_two_numbers(written: Any) -> list[list[Any]]:
    """The second derivatives of a formula with respect to its constants, as functions."""
    return list(written.bends())


def formula_graph(law: Formula) -> tuple[Graph, Expression]:
    """A formula as recorded."""
    graph, found, _ = _recorded(_known(law.function), 0)
    return graph, found


def steps_in(graph: Graph, wanted: list[Expression]) -> list[Expression]:
    """The arguments of step functions in recorded expressions: where one changes sign there is a corner or a jump.

    A nearest whole number changes where the cosine of π times its argument does.
    """
    calls = [
        (node.op, Expression(graph, node.args[0]))
        for n in needed(graph, wanted)
        if (node := graph.nodes[n]).args
    ]
    return [x if op == "positive" else (np.pi * x).call("cos") for op, x in calls if op in JUMPING]


def _known(function: Callable[[Any], Any]) -> Tree | _User:
    return function if isinstance(function, Tree) else _User(function)


def stored(p: Population, k: int, place: int) -> Any:
    """The curve that is stored in number `place` of an element."""
    return p.values[k][next(m for m, n in curves_of(p.kind) if n == place)]


def _value(curve: Any, x: Array, order: int) -> Array:
    """A derivative of a curve."""
    if isinstance(curve, CurveChange):
        return curve.value(x, order)
    if not isinstance(curve, Curve):
        return _derivative(curve.function, x, order)
    piece, powers = _powers(curve, x, order)
    return np.asarray(np.sum(np.array(curve.cubics)[piece].T * powers, axis=0))


def _values(curves: Sequence[Any], x: Array, order: int) -> Array:
    """A derivative of several curves, each at its own x (curves, nt)."""
    rows = np.broadcast_to(x, (len(curves), np.shape(x)[-1] if np.ndim(x) else 1))
    return np.array([_value(curve, row, order) for curve, row in zip(curves, rows, strict=True)])


def _heights(surfaces: Sequence[Surface], x: Any, y: Any, orders: tuple[int, int]) -> Array:
    """A derivative of several surfaces, each at its own x and y (surfaces, nt)."""
    places = np.broadcast_arrays(np.zeros((len(surfaces), 1)), x, y)[1:]
    return np.array([one.derivative(*at, *orders) for one, *at in zip(surfaces, *places, strict=True)])


def entries_of(variant: Variant, name: str) -> tuple[Graph, list[tuple[int, int]], list[Expression]]:
    """A recorded vector: its components with their indices, block along the axis and component of the block."""
    recording = record(variant, (name,))
    graph, blocks = recording.graph, recording.outputs[0].blocks
    places = [
        (block, entry)
        for (block, _), array in zip(structure(variant, OPERATORS[name]), blocks, strict=True)
        for entry in range(array.size)
    ]
    return graph, places, graph.expressions(e for block in blocks for e in np.ravel(block))


def calls_of(graph: Graph, entries: Sequence[Any]) -> list[tuple[int, int, Expression]]:
    """The calls of curves in recorded expressions: order, number that holds the place, and argument."""
    nodes = [graph.nodes[n] for n in _calls(graph, entries)]
    return [
        (ORDERS[node.op], graph.nodes[node.args[0]].value[1], Expression(graph, node.args[1]))
        for node in nodes
    ]


def _calls(graph: Graph, entries: Sequence[Any]) -> list[int]:
    return [n for n in needed(graph, entries) if graph.nodes[n].op in ORDERS]


@cache
def _recipe(variant: Variant, name: str) -> _Recipe:
    graph, places, entries = entries_of(variant, name)
    calls = [Expression(graph, n) for n in _calls(graph, entries)]
    partials, curve_calls = jacobian(graph, entries, calls), calls_of(graph, entries)
    wanted = [*(x for _, _, x in curve_calls), *partials.flat]
    return _Recipe(graph, places, curve_calls, partials, needed(graph, wanted))


def curves_of(kind: Any) -> list[tuple[int, int]]:
    """Return for each curve of an element its index among the values, and that of its parameter."""
    return tables_of(kind, "Curve")


def tables_of(kind: Any, stored: str) -> list[tuple[int, int]]:
    """Return the same for the fields of a kind, curves or surfaces."""
    found, at, value = [], 0, 0
    for field, width in zip(kind.fields.values(), kind.widths(), strict=True):
        if field == "Time":
            continue
        if field == stored:
            found.append((value, at))
        at, value = at + width, value + 1
    return found
