"""Second derivatives of the equations of an operation, contracted: what the change of an adjoint is made of.

An operation with equations R(y, b) = 0 and adjoint variables has the Lagrangian ℓ = μᵀR. Its gradient by everything
that it depends on changes along a direction by the Hessian of ℓ times that direction. Here this change is recorded for
every kind of element, by one sweep backwards and one forwards over its formulas, and compiled for all elements:

    place:   ℓ = λᵀΦ_q ξ + νᵀΦ
    step:    ℓ = λᵀΦ_q ξ + νᵀΦ + ξᵀ(M a - Q - S)
    rate:    ℓ = λᵀΦ_q ξ - νᵀ(Φ_q η + Φ_t) + ξᵀM a
    motion:  ℓ = λᵀΦ_q ξ + νᵀ(Φ_q a - γ(q, v)) + ξᵀ(M a - Q - S)
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np

from ..._jit import pointer
from ..._jit.differentiate import directional
from ..._jit.driver import COMPILING, Signature, compiled_function, driver
from ..._jit.emit import HEADER, Output, Recording
from ..._jit.expression import Graph
from ...algebra import Array
from ...elements import Force, Primitive
from ...elements.derived import HELD
from ...elements.evaluation import element_from, partition
from ...elements.recorder import GROUND, Variant
from ...model.coordinates import WIDTH
from ...system import System
from ...system.population import Population
from . import hessian_loop
from .hessian_loop import Places, Room
from .reverse import gradient

STATES = ("q", "v", "a", "eta")  # operands of bodies that directions are given for
DOTS = tuple(f"{name}_dot" for name in STATES)
OPERANDS = (*STATES, *DOTS, "xi", "lam")
RESULTS = (*STATES, "lam", "b")
OUTPUTS = tuple(f"out_{result}" for result in RESULTS)
SIGNATURE = Signature("lagrangian", ("t",), OPERANDS, OUTPUTS, (False,) * len(RESULTS))
SHARES = 3  # of an element's rows in the operand lam: λ, ν, and the change of λ


class Change(NamedTuple):
    """The change of the gradient of ℓ by coordinates, rates, accelerations, η (nq,), by λ (m,), by the numbers."""

    q: Array
    v: Array
    a: Array
    eta: Array
    lam: Array
    b: Array


def record(variant: Variant, kind: str) -> Recording:
    """The change of the gradient of one element's share of ℓ."""
    graph, cls = Graph(), variant.kind
    moving = {name: graph.inputs(name, variant.moving, WIDTH) for name in (*STATES, *DOTS, "xi")}
    size, rows = cls.size(), cls.rows
    numbers, rows_given = graph.inputs("numbers", 2 * size), graph.inputs("lam", SHARES * rows)
    lam, nu, lam_dot = np.split(rows_given, SHARES) if rows else (rows_given,) * SHARES
    element = element_from(cls, numbers[:size], t=graph.input("t"))
    local = {name: _local(variant, moving[name], name) for name in (*STATES, "xi")}
    value = _share(element, kind, local, lam, nu, graph.input("t"))
    b, held = numbers[:size], _held(cls)
    by = [*(x for name in STATES for x in moving[name].flat), *lam, *b]
    dots = [*(x for name in DOTS for x in moving[name].flat), *lam_dot, *numbers[size:]]
    kept = [*[True] * (len(by) - size), *(not hold for hold in held)]
    found = gradient(graph, value, by)
    wanted = [x if not isinstance(x, int | float) else graph.constant(x) for x in found]
    pairs = [(x, dot) for x, dot, keep in zip(by, dots, kept, strict=True) if keep]
    change = [x if keep else 0 for x, keep in zip(directional(graph, wanted, pairs), kept, strict=True)]
    recording = Recording(f"{variant.name}.{kind}", graph, variant.moving, 2 * size, OPERANDS, ("t",))
    recording.outputs += _outputs(change, variant.moving, rows, size)
    return recording


def _outputs(change: list[Any], moving: int, rows: int, size: int) -> list[Output]:
    """One block for each moving body, then one of rows and one of numbers."""
    flat = np.array(change, dtype=object)
    cuts = np.cumsum([WIDTH * moving] * len(STATES))
    parts = np.split(flat, [*cuts, cuts[-1] + rows])
    blocks = [list(part.reshape(moving, WIDTH)) for part in parts[: len(STATES)]]
    return [Output(own, True) for own in (*blocks, [parts[-2]] if rows else [], [parts[-1]] if size else [])]


def _local(variant: Variant, symbols: Array, name: str) -> Any:
    ground = GROUND if name == "q" else (0,) * WIDTH
    parts = [np.array(ground, dtype=object) if slot < 0 else symbols[slot] for slot in variant.slots]
    return partition(variant.kind, np.concatenate(parts))


def _held(cls: Any) -> list[bool]:
    fields = zip(cls.fields.values(), cls.widths(), strict=True)
    return [kind in HELD for kind, width in fields for _ in range(width)]


def _share(element: Any, kind: str, x: dict[str, Any], lam: Array, nu: Array, t: Any) -> Any:
    """ℓ of one element."""
    if isinstance(element, Primitive):
        return _of_constraint(element, kind, x, lam, nu)
    if kind == "rate":
        return _dot(x["xi"], element.M_a(x["q"], x["a"]))
    if isinstance(element, Force):
        return -_dot(x["xi"], element.Q(x["q"], x["v"], t))  # type: ignore[attr-defined]
    return _dot(x["xi"], element.M_a(x["q"], x["a"])) - _dot(x["xi"], element.S(x["q"], x["v"]))


def _of_constraint(element: Any, kind: str, x: dict[str, Any], lam: Array, nu: Array) -> Any:
    q = x["q"]
    first = lam @ element.Phi_q_xi(q, x["xi"])
    if kind in ("place", "step"):
        return first + nu @ element.Phi(q)
    if kind == "motion":
        return first + nu @ (element.Phi_q_xi(q, x["a"]) - element.gamma(q, x["v"]))
    rate = element.Phi_q_xi(q, x["eta"])
    drift = element.Phi_t(q) if element.timed else None
    return first - nu @ (rate if drift is None else rate + drift)


def _dot(direction: Any, blocks: Any) -> Any:
    return sum(part @ block for part, block in zip(direction, blocks, strict=True) if block is not None)


class Lagrangian:
    """The change of the gradient of ℓ for all elements of a system.

    Parameters
    ----------
    system : System
    kind : "place", "step", "rate" or "motion"
    """

    def __init__(self, system: System, kind: str) -> None:
        self._system = system
        self._populations = [p for p in system.populations if p.count and not _absent(p, kind)]
        self._shift = system.nb
        self._numbers = np.zeros(2 * system.nb + len(system.b) - system.nb)
        self._b_places, self._dot_places, self._curves = _places_of_numbers(system)
        self._row_places = _places_of_rows(system)
        self._tables = [_table(p) for p in self._populations]
        self._drivers = [_driver(p.variant, kind) for p in self._populations]
        self._lam = np.zeros(SHARES * system.m)

    @cached_property
    def entry(self) -> pointer.Entry:
        """The drivers, to be called by their addresses: `compiled`."""
        return pointer.entry(self._drivers, self._tables, SIGNATURE)

    def places(self, memory: Array) -> Places:
        """Where numbers of b in some places, and λ, ν and the change of λ, stand among the operands."""
        return Places(self._b_places[memory], np.stack(self._row_places))

    def numbers(self, b: Array, b_dot: Array) -> Array:
        """The elements' numbers and their changes, as the drivers take them."""
        count, numbers = self._system.nb, self._numbers
        numbers[self._b_places], numbers[self._dot_places] = b[:count], b_dot[:count]
        numbers[self._curves] += self._shift  # curves lie behind the numbers and their changes
        numbers[2 * count :] = b[count:]
        return numbers

    def room(self) -> Room:
        """Operands and results of one call, all zero."""
        nq, m = self._system.nq, self._system.m
        shapes = {"lam": SHARES * m, "by_lam": m}
        return Room._make(np.zeros(shapes.get(name, nq)) for name in Room._fields)

    def __call__(
        self, t: float, b: Array, b_dot: Array, lam: Array, nu: Array, lam_dot: Array, **x: Array
    ) -> Change:
        """Evaluate; operands that are not given are zero."""
        system, numbers = self._system, self.numbers(b, b_dot)
        for places, values in zip(self._row_places, (lam, nu, lam_dot), strict=True):
            self._lam[places] = values
        none = np.zeros(system.nq)
        given = [np.ascontiguousarray(x.get(name, none)) for name in OPERANDS[:-1]]
        coordinates = [np.zeros(system.nq) for _ in STATES]
        found = Change._make([*coordinates, np.zeros(system.m), np.zeros(len(b))])
        for run, table in zip(self._drivers, self._tables, strict=True):
            run(table, numbers, float(t), *given, self._lam, *found)
        return found


def _absent(p: Population, kind: str) -> bool:
    if kind == "place":
        return not issubclass(p.kind, Primitive)
    return kind == "rate" and issubclass(p.kind, Force)


def _places_of_numbers(system: System) -> tuple[Array, Array, Array]:
    """Where numbers and their changes go, side by side for each element; and which numbers are places of curves."""
    here, dots, curves = np.zeros(system.nb, np.int64), np.zeros(system.nb, np.int64), []
    for p in system.populations:
        size, starts = p.kind.size(), np.cumsum([0, *p.kind.widths()])
        for k in range(p.count):
            at = p.at + k * size
            own = np.arange(size)
            here[at + own], dots[at + own] = (
                p.at * 2 + 2 * k * size + own,
                p.at * 2 + (2 * k + 1) * size + own,
            )
            fields = zip(starts[:-1], p.kind.fields.values(), strict=True)
            curves += [int(here[at + start]) for start, kind in fields if kind == "Curve"]
    return here, dots, np.array(curves, dtype=np.int64)


def _places_of_rows(system: System) -> tuple[Array, Array, Array]:
    """Where λ, ν and the change of λ of each equation go: those of one element lie together."""
    places = np.zeros((SHARES, system.m), np.int64)
    for p in system.populations:
        for k in range(p.count if p.kind.rows else 0):
            rows = np.arange(p.kind.rows)
            for share in range(SHARES):
                places[share, p.rows[k] + rows] = SHARES * p.rows[k] + share * p.kind.rows + rows
    return places[0], places[1], places[2]


def _table(p: Population) -> Array:
    """Header, bodies, rows and places of a population, as `emit` reads them."""
    moving, size, rows = p.variant.moving, p.kind.size(), p.kind.rows
    bodies = [_place(p.bodies[:, slot]) for slot in range(moving)]
    coordinates = np.stack(bodies, axis=1) if bodies else np.zeros((p.count, 0, 2), np.int64)
    along_rows = _place(p.rows)[:, None] if rows else np.zeros((p.count, 0, 2), np.int64)
    along_b = (
        _place(p.at + size * np.arange(p.count))[:, None] if size else np.zeros((p.count, 0, 2), np.int64)
    )
    places = [*[coordinates] * len(STATES), along_rows, along_b]
    parts = [part.reshape(-1) for part in (p.bodies, SHARES * p.rows, *places)]
    width = HEADER + len(RESULTS)
    starts = width + np.cumsum([0, *(len(part) for part in parts)])
    header = [p.count, starts[0], starts[1], 2 * p.at, *starts[2:-1]]
    return np.concatenate([header, *parts]).astype(np.int64)


def _place(first: Array) -> Array:
    return np.stack([np.asarray(first), np.ones(len(first))], axis=1).astype(np.int64)


@cache
def _driver(variant: Variant, kind: str) -> Any:
    """Compiled under the hash of what it computes."""
    recording = record(variant, kind)
    name = f"lagrangian_{variant.name}_{kind}_{recording.fingerprint()}"
    with COMPILING:
        return driver(replace(SIGNATURE, name=name), [lambda: recording], clear=False)


@cache
def compiled() -> dict[str, Any]:
    """The loops over all steps."""
    known: dict[str, Any] = {"RUN": pointer.run(1, len(OPERANDS) + len(RESULTS))}
    for name in ("begin", "solved_rows", "of_steps", "of_rescales"):
        known[name] = compiled_function(getattr(hessian_loop, name), **known)
    return known
