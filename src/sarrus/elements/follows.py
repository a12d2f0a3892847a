"""Operators that follow from others, once for all elements. Φ_qq is symmetric, so no new formula is needed:

gamma = -(Φ_q v)_q v,   gamma_q = -((Φ_q v)_q v)_q,   gamma_v = -2 (Φ_q v)_q.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from ..algebra import Block, Row, scaled, times, total
from .derived import derived


def contracted(blocks: Row, direction: Any) -> Block:
    """A row of blocks times a direction."""
    return total(times(block, part) for block, part in zip(blocks, direction, strict=True))


class ConstraintFollows:
    """Derived operators of every constraint primitive. Terms in t appear only where Φ depends on time by itself."""

    timed: ClassVar[bool]
    Phi_q: Callable[..., Row]
    Phi_q_xi_q: Callable[..., Row]
    Phi_q_xi_q_eta_q: Callable[..., Row]
    Phi_q_xi_q_eta_b: Callable[..., Row]
    Phi_tt: Callable[..., Block]
    Phi_q_xi_t: Callable[..., Block]

    def Phi_q_xi(self, x: Any, xi: Any) -> Block:
        """Φ_q ξ. Eqs. (36)."""
        return contracted(self.Phi_q(x), xi)

    def Phi_qT_lam(self, x: Any, lam: Any) -> Row:
        """Φ_qᵀ λ. Eq. (43)."""
        return tuple(None if block is None else lam @ block for block in self.Phi_q(x))

    def gamma(self, x: Any, v: Any) -> Block:
        """γ = -(Φ_q v)_q v - 2 (Φ_q v)_t - Φ_tt. Eq. (4)."""
        own = scaled(-1, contracted(self.Phi_q_xi_q(x, v), v))
        if not self.timed:
            return own
        return total((own, scaled(-2, self.Phi_q_xi_t(x, v)), scaled(-1, self.Phi_tt(x))))

    def gamma_q(self, x: Any, v: Any) -> Row:
        """γ_q = -((Φ_q v)_q v)_q, and the derivative of the terms in t, which vanishes where Φ_tq does."""
        if self.timed and self.Phi_q_xi_t(x, v) is not None:
            return derived("gamma_q")(self, x, v)
        return tuple(scaled(-1, block) for block in self.Phi_q_xi_q_eta_q(x, v, v))

    def gamma_v(self, x: Any, v: Any) -> Row:
        """γ_v = -2 (Φ_q v)_q, and the derivative of the terms in t, which vanishes where Φ_tq does."""
        if self.timed and self.Phi_q_xi_t(x, v) is not None:
            return derived("gamma_v")(self, x, v)
        return tuple(scaled(-2, block) for block in self.Phi_q_xi_q(x, v))

    def gamma_b(self, x: Any, v: Any) -> Row:
        """γ_b = -((Φ_q v)_q v)_b, and the derivative of the terms in t."""
        if self.timed:
            return derived("gamma_b")(self, x, v)
        return tuple(scaled(-1, block) for block in self.Phi_q_xi_q_eta_b(x, v, v))


class NonholonomicFollows(ConstraintFollows):
    """Derived operators of constraints on velocities, Φ_q v = 0, whose Φ_q is no derivative of a Φ."""

    def Phi(self, x: Any) -> Block:
        """None: positions are not restricted."""
        return None

    def gamma_q(self, x: Any, v: Any) -> Row:
        """γ_q = -((Φ_q v)_q v)_q."""
        return derived("gamma_q")(self, x, v)

    def gamma_v(self, x: Any, v: Any) -> Row:
        """γ_v = -((Φ_q v)_q v)_v; (Φ_q v)_q ξ is not symmetric in v and ξ."""
        return derived("gamma_v")(self, x, v)

    def gamma_b(self, x: Any, v: Any) -> Row:
        """γ_b = -((Φ_q v)_q v)_b."""
        return derived("gamma_b")(self, x, v)


class InertiaFollows:
    """Derived operators of every inertia."""

    M: Callable[..., tuple[Row, ...]]

    def M_a(self, x: Any, a: Any) -> Row:
        """M a."""
        return tuple(contracted(line, a) for line in self.M(x))
