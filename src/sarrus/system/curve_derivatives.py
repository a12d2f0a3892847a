"""How the equations change with what curves are made of: coefficients of tables, numbers of formulas; at many times.

An operator takes curves by their values and slopes, f⁽ᵒ⁾(x); with the derivatives of what it gives by these, recorded
exactly, its change with a number c of a curve is the sum of those times ∂f⁽ᵒ⁾/∂c at x. A number of a curve has a column
behind those of all elements: a coefficient of a table its own, the numbers of a formula one after another from the
place at which the curve is stored.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csr_array

from .._jit.differentiate import jacobian
from .._jit.expression import Expression, Graph
from .._jit.replay import OPERATIONS, needed
from ..algebra import Array
from ..elements.operators import OPERATORS, Axis
from ..elements.recorder import Variant, record, structure
from ..model import Curve
from ..model.coordinates import WIDTH
from .population import Population
from .system import System

ORDERS = {"curve": 0, "curve_slope": 1, "curve_bend": 2, "curve_twist": 3}
EVERY: dict[str, Callable[..., Any]] = OPERATIONS | {
    **{name: getattr(np, name) for name in ("sin", "cos", "tan", "exp", "log", "tanh", "sqrt")},
    **{f"a{name}": getattr(np, f"arc{name}") for name in ("sin", "cos", "tan")},
    "atan2": np.arctan2,
}  # of arrays over time, and of traced numbers
MANY: dict[str, Callable[..., Any]] = EVERY | {
    "nearest": lambda x: np.floor(x + 0.5),
    "positive": lambda x: np.where(x > 0, 1.0, 0.0),
    **{name: lambda curve, x, order=n: _value(curve, np.atleast_1d(x), order) for name, n in ORDERS.items()},
}  # of arrays over time


class Entries(NamedTuple):
    """Derivatives of an operator by numbers of curves: rows (n,), columns (n, nt) and values (n, nt) at nt times."""

    rows: Array
    columns: Array
    values: Array

    def along(self, db: Array, height: int) -> Array:
        """The change of the operator (nt, height, k) with changes of the numbers (len(b), k)."""
        found = np.zeros((self.values.shape[1], height, db.shape[1]))
        for row, columns, values in zip(self.rows, self.columns, self.values, strict=True):
            found[:, row] += values[:, None] * db[columns]
        return found

    def gradient(self, weights: Array, size: int) -> Array:
        """The gradient (size, k) of the operator's sum over rows and times with weights (nt, height, k)."""
        columns, found = self.columns.reshape(-1), np.zeros((size, weights.shape[2]))
        for k, by_row in enumerate(weights.T):
            terms = self.values * by_row[self.rows]
            found[:, k] = np.bincount(columns, terms.reshape(-1), minlength=size)
        return found

    def matrix(self, height: int, width: int) -> csr_array:
        """The derivatives at the only time."""
        places = self.rows, self.columns[:, 0]
        return csr_array((self.values[:, 0], places), shape=(height, width))


class _Recipe(NamedTuple):
    """One operator of a variant: its entries, its calls of curves, and the derivatives of the entries by them.

    places : of the entries: block along the axis, entry of the block
    calls : order, number that holds the place, and argument
    """

    graph: Graph
    places: list[tuple[int, int]]
    calls: list[tuple[int, int, Expression]]
    partials: Array


class CurveDerivatives:
    """The derivatives of a system's operators by the numbers of its curves.

    Parameters
    ----------
    system : System
    """

    def __init__(self, system: System) -> None:
        self._system = system
        self._members = [(p, k) for p in system.populations if self.concerns(p) for k in range(p.count)]

    def concerns(self, p: Population) -> bool:
        """Whether elements of a kind have such derivatives."""
        return "Curve" in p.kind.fields.values()

    @property
    def width(self) -> int:
        """How many columns there are."""
        return len(self._system.b)

    def __bool__(self) -> bool:
        return bool(self._members)

    def __call__(self, name: str, b: Array, memory: Mapping[int, Any], **operands: Any) -> Entries:
        """The derivatives of an operator.

        Parameters
        ----------
        name : of a vector: "Phi", "Phi_t", "Phi_q_xi", "Phi_qT_lam", "gamma", "Q"
        b : (len(system.b),) numbers
        memory : what elements remembered at each time (nt,), by place in b
        operands : the time ``t`` (nt,), and what the operator takes, as (nt, nq) or (nt, m)
        """
        parts = [
            part
            for p, k in self._members
            if OPERATORS[name] in p.kind.family
            for part in self._of_element(p, k, name, b, memory, operands)
        ]
        if not parts:
            none = np.zeros((0, len(operands["t"])))
            return Entries(np.zeros(0, dtype=np.int64), none.astype(np.int64), none)
        return Entries(*(np.concatenate(x) for x in zip(*parts, strict=True)))

    def matrix(self, name: str, b: Array, t: float, **operands: Array) -> csr_array:
        """The derivatives of an operator at one time, as wide as all columns; operands are (nq,) or (m,)."""
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
        curve = p.values[k][next(m for m, n in _curves_of(p.kind) if n == place)]
        bases = [self._basis(p, k, place, order + n, x) for n in range(2)]
        numbers = np.unique(bases[0][0]).tolist()
        by = [[np.sum(basis * (at == n), axis=0) for n in numbers] for at, basis in bases]
        return [_value(curve, x, order + n) for n in range(3)], numbers, by

    def _of_element(
        self, p: Population, k: int, name: str, b: Array, memory: Mapping[int, Any], operands: Any
    ) -> list[Entries]:
        recipe = _recipe(p.variant, name)
        inputs = self._inputs(p, k, b, memory, operands)
        shape = operands["t"].shape
        flat = [*(x for _, _, x in recipe.calls), *(e for e in recipe.partials.flat)]
        found = [np.broadcast_to(x, shape) for x in evaluated(recipe.graph, flat, inputs)]
        count = len(recipe.calls)
        slopes = np.array(found[count:]).reshape(*recipe.partials.shape, *shape)
        rows = np.array([self._row(p, k, name, *place) for place in recipe.places], dtype=np.int64)
        parts = []
        for j, (order, place, _) in enumerate(recipe.calls):
            columns, basis = self._basis(p, k, place, order, found[j])
            values = slopes[:, j, None] * basis[None]  # (entries, numbers, nt)
            parts.append(
                Entries(
                    np.repeat(rows, len(basis)),
                    np.tile(columns, (len(rows), 1)),
                    values.reshape(len(rows) * len(basis), *shape),
                )
            )
        return parts

    def _inputs(
        self, p: Population, k: int, b: Array, memory: Mapping[int, Any], operands: Mapping[str, Any]
    ) -> dict[tuple[Any, ...], Any]:
        at = p.at + k * p.kind.size()
        inputs: dict[tuple[Any, ...], Any] = {
            ("numbers", n): memory.get(at + n, b[at + n]) for n in range(p.kind.size())
        }
        inputs |= {("numbers", n): p.values[k][m] for m, n in _curves_of(p.kind)}
        for name, array in operands.items():
            if name == "t":
                inputs["t",] = array
            elif name == "lam":
                inputs |= {("lam", n): array[:, p.rows[k] + n] for n in range(p.kind.rows)}
            else:
                bodies = enumerate(p.bodies[k])
                inputs |= {(name, i, n): array[:, first + n] for i, first in bodies for n in range(WIDTH)}
        return inputs

    def _row(self, p: Population, k: int, name: str, block: int, entry: int) -> int:
        """The row of an entry of a block."""
        if OPERATORS[name].axes[0] is Axis.ROWS:
            return int(p.rows[k]) + entry
        return int(p.bodies[k, block // 2]) + (3 if block % 2 else 0) + entry

    def _basis(self, p: Population, k: int, place: int, order: int, x: Array) -> tuple[Array, Array]:
        """Columns (numbers, nt) of a curve's numbers, and the derivatives of f⁽ᵒ⁾(x) by them (numbers, nt)."""
        at = int(self._system.b[p.at + k * p.kind.size() + place])
        curve = p.values[k][next(m for m, n in _curves_of(p.kind) if n == place)]
        if isinstance(curve, Curve):
            piece, powers = _powers(curve, x, order)
            return at + 2 + len(curve.cubics) + 4 * piece + np.arange(4)[:, None], powers
        slopes = curve.written.slopes() if curve.written else []
        columns = np.tile(at + np.arange(len(slopes))[:, None], (1, len(x)))
        return columns, np.array([_derivative(f, x, order) for f in slopes]).reshape(columns.shape)


def _powers(curve: Curve, x: Array, order: int) -> tuple[Array, Array]:
    """The piece in which each x lies (nt,), and what the derivative there has of its four coefficients (4, nt)."""
    knots = np.array(curve.knots)
    piece = np.searchsorted(knots[1:-1], x, side="right")
    u = x - knots[piece]
    powers = [np.polyval(np.polyder(row, order), u) if order else np.polyval(row, u) for row in np.eye(4)]
    return piece, np.array(powers)


def _derivative(function: Callable[[Any], Any], x: Array, order: int) -> Array:
    """A derivative of a recorded function of one variable (nt,)."""
    graph = Graph()
    variable = graph.input("x")
    found = constant(graph, function(variable))
    for _ in range(order):
        found = constant(graph, jacobian(graph, [found], [variable])[0, 0])
    return np.broadcast_to(np.asarray(evaluated(graph, [found], {("x",): x})[0], dtype=float), x.shape)


def _value(curve: Any, x: Array, order: int) -> Array:
    """A derivative of a curve."""
    if not isinstance(curve, Curve):
        return _derivative(curve.function, x, order)
    piece, powers = _powers(curve, x, order)
    return np.asarray(np.sum(np.array(curve.cubics)[piece].T * powers, axis=0))


def constant(graph: Graph, value: Any) -> Expression:
    """A recorded value as an expression."""
    return value if isinstance(value, Expression) else graph.constant(value)


def entries_of(variant: Variant, name: str) -> tuple[Graph, list[tuple[int, int]], list[Expression]]:
    """A vector recorded: its entries with their places, block along the axis and entry of the block."""
    recording = record(variant, (name,))
    graph, blocks = recording.graph, recording.outputs[0].blocks
    places = [
        (block, entry)
        for (block, _), array in zip(structure(variant, OPERATORS[name]), blocks, strict=True)
        for entry in range(array.size)
    ]
    return graph, places, [constant(graph, e) for block in blocks for e in np.ravel(block)]


@cache
def _recipe(variant: Variant, name: str) -> _Recipe:
    graph, places, entries = entries_of(variant, name)
    calls = [Expression(graph, n) for n in needed(graph, entries) if graph.nodes[n].op in ORDERS]
    partials = jacobian(graph, entries, calls)
    nodes = [graph.nodes[call.id] for call in calls]
    told = [
        (ORDERS[node.op], graph.nodes[node.args[0]].value[1], Expression(graph, node.args[1]))
        for node in nodes
    ]
    for place in np.ndindex(*partials.shape):
        partials[place] = constant(graph, partials[place])
    return _Recipe(graph, places, told, partials)


def evaluated(
    graph: Graph,
    wanted: list[Expression],
    inputs: Mapping[tuple[Any, ...], Any],
    operations: Mapping[str, Callable[..., Any]] = MANY,
) -> list[Any]:
    """Recorded expressions at many times."""
    values: dict[int, Any] = {}
    for identity in needed(graph, wanted):
        node = graph.nodes[identity]
        if node.op == "constant":
            values[identity] = float(node.value)  # fractions are recorded, too
        elif node.op == "input":
            values[identity] = inputs[node.value]
        else:
            values[identity] = operations[node.op](*(values[arg] for arg in node.args))
    return [values[expression.id] for expression in wanted]


def _curves_of(kind: Any) -> list[tuple[int, int]]:
    """Of each curve of an element: its place among the values, and that of its number."""
    found, at, value = [], 0, 0
    for field, width in zip(kind.fields.values(), kind.widths(), strict=True):
        if field == "Time":
            continue
        if field == "Curve":
            found.append((value, at))
        at, value = at + width, value + 1
    return found
