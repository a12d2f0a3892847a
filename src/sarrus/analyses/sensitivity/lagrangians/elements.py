"""Contribution of one element to ℓ = μᵀR, the equations of an operation times their adjoint variables.

An operation with equations R(y, b) = 0 and adjoint variables has the Lagrangian ℓ = μᵀR, which is recorded from the
kernels of every kind of element:

    place:   ℓ = λᵀΦ_q ξ + νᵀΦ
    step:    ℓ = λᵀΦ_q ξ + νᵀΦ + ξᵀ(M a - Q - S)
    rate:    ℓ = λᵀΦ_q ξ - νᵀ(Φ_q v + Φ_t)
    impulse: ℓ = λᵀΦ_q ξ - νᵀ(Φ_q v + Φ_t) + ξᵀM a
    motion:  ℓ = λᵀΦ_q ξ + νᵀ(Φ_q a - γ(q, v)) + ξᵀ(M a - Q - S)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...._jit.formulas.expression import Graph
from ...._jit.kernels.emit import Output, Recording
from ....algebra import Array
from ....elements import Force, Primitive
from ....elements.derived import HELD
from ....elements.evaluation import element_from
from ....elements.recorder import Variant
from ....system import System
from ....system.curves.lanes import local
from ....system.structure.population import Population

STATES = ("q", "v", "a")  # operands of bodies besides ξ


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
        """Inputs for the coordinates of the moving bodies."""
        return self.variant.inputs(self.graph, name)

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


def _share(element: Any, kind: str, x: dict[str, Any], lam: Array, nu: Array, t: Any) -> Any:
    """ℓ of one element."""
    if isinstance(element, Primitive):
        return _of_constraint(element, kind, x, lam, nu)
    if kind == "impulse":
        return _dot(x["xi"], element.M_a(x["q"], x["a"]))
    if isinstance(element, Force):
        return -_dot(x["xi"], element.Q(x["q"], x["v"], t))
    return _dot(x["xi"], element.M_a(x["q"], x["a"])) - _dot(x["xi"], element.S(x["q"], x["v"]))


def _of_constraint(element: Any, kind: str, x: dict[str, Any], lam: Array, nu: Array) -> Any:
    q = x["q"]
    first = lam @ element.Phi_q_xi(q, x["xi"])
    if kind in ("place", "step"):
        Phi = element.Phi(q)
        return first if Phi is None else first + nu @ Phi
    if kind == "motion":
        return first + nu @ (element.Phi_q_xi(q, x["a"]) - element.gamma(q, x["v"]))
    rate = element.Phi_q_xi(q, x["v"])
    drift = element.Phi_t(q) if element.timed else None
    return first - nu @ (rate if drift is None else rate + drift)


def _dot(direction: Any, blocks: Any) -> Any:
    return sum(part @ block for part, block in zip(direction, blocks, strict=True) if block is not None)


def concerned(system: System, kind: str) -> list[Population]:
    """The elements that add to ℓ."""
    return [p for p in system.populations if p.count and not _absent(p, kind)]


def _absent(p: Population, kind: str) -> bool:
    if kind in ("place", "rate"):
        return not issubclass(p.kind, Primitive)
    return kind == "impulse" and issubclass(p.kind, Force)
