"""What does one element add to ℓ = μᵀR, the equations of an operation times their adjoint variables?

An operation with equations R(y, b) = 0 and adjoint variables has the Lagrangian ℓ = μᵀR, which is recorded from the
kernels of every kind of element:

    place:   ℓ = λᵀΦ_q ξ + νᵀΦ
    step:    ℓ = λᵀΦ_q ξ + νᵀΦ + ξᵀ(M a - Q - S)
    rate:    ℓ = λᵀΦ_q ξ - νᵀ(Φ_q η + Φ_t) + ξᵀM a
    motion:  ℓ = λᵀΦ_q ξ + νᵀ(Φ_q a - γ(q, v)) + ξᵀ(M a - Q - S)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..._jit import pointer
from ..._jit.driver import COMPILING, Signature, driver
from ..._jit.emit import HEADER, Output, Recording
from ..._jit.expression import Expression, Graph
from ..._jit.vector import LANES
from ...algebra import Array
from ...elements import Force, Primitive
from ...elements.derived import HELD
from ...elements.evaluation import element_from, partition
from ...elements.recorder import GROUND, Variant
from ...model.coordinates import WIDTH
from ...system import System
from ...system.population import Population

STATES = ("q", "v", "a", "eta")  # operands of bodies besides ξ


class Share:
    """ℓ of one element, recorded; and its inputs."""

    def __init__(self, variant: Variant, kind: str) -> None:
        self.variant, self.kind, self.graph = variant, kind, Graph()
        cls, graph = variant.kind, self.graph
        self.moving = {name: self.coordinates(name) for name in (*STATES, "xi")}
        self.numbers = graph.inputs("numbers", cls.size())
        self.lam, self.nu = self.rows("lam"), self.rows("nu")
        element = element_from(cls, self.numbers, t=graph.input("t"))
        parts = {name: local(variant, own, name) for name, own in self.moving.items()}
        self.value = _share(element, kind, parts, self.lam, self.nu, graph.input("t"))
        fields = zip(cls.fields.values(), cls.widths(), strict=True)
        self.held = [field in HELD for field, width in fields for _ in range(width)]

    def coordinates(self, name: str) -> Array:
        """Inputs for the moving bodies (bodies, 7)."""
        return self.graph.inputs(name, self.variant.moving, WIDTH)

    def rows(self, name: str) -> Array:
        """Inputs for the equations."""
        return self.graph.inputs(name, self.variant.kind.rows)

    def free(self, of_numbers: Sequence[Any]) -> list[Any]:
        """What belongs to the numbers, 0 for those that nothing is differentiated by."""
        return [0 if hold else x for x, hold in zip(of_numbers, self.held, strict=True)]

    def recording(self, arrays: tuple[str, ...], blocks: list[list[Array]]) -> Recording:
        """What is compiled: outputs of some blocks each, which add to what is there."""
        variant, size = self.variant, self.variant.kind.size()
        found = Recording(f"{variant.name}.{self.kind}", self.graph, variant.moving, size, arrays, ("t",))
        found.outputs += [Output(own, True) for own in blocks]
        return found

    def by_body(self, of_coordinates: Sequence[Any]) -> list[Array]:
        """One block for each moving body."""
        return list(np.array(of_coordinates, dtype=object).reshape(-1, WIDTH))

    def expressions(self, found: Sequence[Any]) -> list[Expression]:
        """Plain numbers recorded too."""
        return [x if isinstance(x, Expression) else self.graph.constant(x) for x in found]


def block(values: Sequence[Any]) -> list[Array]:
    """One block, or none if there is nothing in it."""
    return [np.array(values, dtype=object)] if len(values) else []


def local(variant: Variant, symbols: Array, name: str) -> Any:
    """Coordinates, or a direction in them, of an element's bodies, some of which may be the ground."""
    ground = GROUND if name == "q" else (0,) * WIDTH
    parts = [np.array(ground, dtype=object) if slot < 0 else symbols[slot] for slot in variant.slots]
    return partition(variant.kind, np.concatenate(parts))


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


def concerned(system: System, kind: str) -> list[Population]:
    """The elements that add to ℓ."""
    return [p for p in system.populations if p.count and not _absent(p, kind)]


def _absent(p: Population, kind: str) -> bool:
    if kind == "place":
        return not issubclass(p.kind, Primitive)
    return kind == "rate" and issubclass(p.kind, Force)


def entry(
    populations: Sequence[Population],
    recordings: Sequence[Recording],
    outputs: Sequence[str],
    title: str,
    firsts: Sequence[int] | None = None,
) -> pointer.Entry:
    """Drivers in lanes, one for each population, to be called by their addresses; `outputs` names what each is along.

    Compiled under the hash of what they compute. `firsts`: where the numbers of each population begin in an output
    along numbers; by default as in b.
    """
    places = [p.at for p in populations] if firsts is None else firsts
    tables = [_table(p, outputs, first) for p, first in zip(populations, places, strict=True)]
    return entry_with(tables, recordings, outputs, title)


def entry_with(
    tables: Sequence[Array], recordings: Sequence[Recording], outputs: Sequence[str], title: str
) -> pointer.Entry:
    """The same with tables of one's own."""
    found = [_driver(recording, outputs, title) for recording in recordings]
    return (
        pointer.entry(found, [*tables], _signature(recordings[0], outputs, title)) if found else pointer.NONE
    )


def _signature(recording: Recording, outputs: Sequence[str], title: str) -> Signature:
    name = f"{title}_x{LANES}_{recording.name}_{recording.fingerprint()}"
    outs = tuple(f"out_{n}" for n in range(len(outputs)))
    return Signature(name, ("t",), recording.arrays, outs, (False,) * len(outs), lanes=LANES)


def _driver(recording: Recording, outputs: Sequence[str], title: str) -> Any:
    own = _signature(recording, outputs, title)
    with COMPILING:
        if own.name not in _drivers:
            _drivers[own.name] = driver(own, [lambda: recording], clear=False)
        return _drivers[own.name]


_drivers: dict[str, Any] = {}


def _table(p: Population, outputs: Sequence[str], first: int) -> Array:
    """Header, bodies, rows and places of a population, as `emit` reads them."""
    coordinates = [_place(p.bodies[:, slot]) for slot in range(p.variant.moving)]
    none = np.zeros((p.count, 0, 2), np.int64)
    places = {
        "coordinates": np.stack(coordinates, axis=1) if coordinates else none,
        "rows": _place(p.rows)[:, None] if p.kind.rows else none,
        "numbers": _place(first + p.kind.size() * np.arange(p.count))[:, None] if p.kind.size() else none,
        "one": _place(np.zeros(p.count, np.int64))[:, None],
    }
    parts = [part.reshape(-1) for part in (p.bodies, p.rows, *(places[along] for along in outputs))]
    starts = HEADER + len(outputs) + np.cumsum([0, *(len(part) for part in parts)])
    header = [p.count, starts[0], starts[1], p.at, *starts[2:-1]]
    return np.concatenate([header, *parts]).astype(np.int64)


def own_tables(p: Population) -> Array:
    """For every element of a population a table by itself (count, entries).

    What it computes along the coordinates of its bodies, and then along its equations, is put one after another.
    """
    bodies, numbers = p.bodies.reshape(p.count, -1), p.at + p.kind.size() * np.arange(p.count)
    along = [(WIDTH * slot, 1) for slot in range(p.variant.moving + bool(p.kind.rows))]
    first = HEADER + 2
    header = [1, first, first + bodies.shape[1], first + bodies.shape[1] + 1, 0]
    header[4] = header[3] + 2 * p.variant.moving
    table = [np.tile(header[:3], (p.count, 1)), numbers[:, None], np.tile(header[3:], (p.count, 1))]
    table += [bodies, p.rows.reshape(-1, 1), np.tile(np.ravel(along), (p.count, 1))]
    return np.concatenate(table, axis=1).astype(np.int64)


def own_rows(p: Population, nq: int) -> Array:
    """Which equations the results of `own_tables` belong to (count, results), those of constraints after all others."""
    coordinates = (p.bodies.reshape(p.count, -1, 1) + np.arange(WIDTH)).reshape(p.count, -1)
    return np.concatenate([coordinates, nq + p.rows.reshape(-1, 1) + np.arange(p.kind.rows)], axis=1)


def _place(first: Array) -> Array:
    return np.stack([np.asarray(first), np.ones(len(first))], axis=1).astype(np.int64)
