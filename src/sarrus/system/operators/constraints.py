"""The constraint operators of a system, by their public names."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from ...algebra import Array
from .operators import Operators


class ConstraintOperators(Operators):
    """Φ and its derivatives. Joint equations come first, in the model's order, then one normalization per body.

    All methods take the coordinates ``q`` (nq,), for any length of the Euler parameters, and the time ``t`` [s], on
    which only drivers depend; optionally other numbers ``b`` than the model's (nb,), and ``out``, an earlier result of
    the same method whose memory is reused. They raise ValueError for a wrong shape. Units: those of Φ (m for spherical,
    m² for distance, m for DOT-2, 1 for DOT-1 and normalization), per unit of what they are differentiated by.
    """

    def Phi(self, q: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None) -> Array:
        """Constraint residual Φ(q). Eqs. (26)-(29), (33), (88).

        Returns
        -------
        ndarray (m,)
        """
        return self._vector_of("Phi", out, b, q=q, t=t)

    def Phi_q(self, q: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None) -> csr_array:
        """Constraint Jacobian Φ_q. Eqs. (35), (46), (81), (89), (96).

        Returns
        -------
        csr_array (m, nq)
        """
        return self._evaluate("Phi_q", out, b, q=q, t=t)

    def Phi_q_xi(
        self, q: ArrayLike, xi: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None
    ) -> Array:
        """Φ_q ξ, without forming the Jacobian. Eq. (36).

        Returns
        -------
        ndarray (m,)
        """
        return self._vector_of("Phi_q_xi", out, b, q=q, xi=xi, t=t)

    def Phi_q_xi_q(
        self, q: ArrayLike, xi: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None
    ) -> csr_array:
        """(Φ_q ξ)_q for a fixed direction ξ (nq,). Eqs. (38), (47), (82), (90), (99).

        Returns
        -------
        csr_array (m, nq)
        """
        return self._evaluate("Phi_q_xi_q", out, b, q=q, xi=xi, t=t)

    def Phi_q_xi_q_eta_q(
        self, q: ArrayLike, xi: ArrayLike, eta: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None
    ) -> csr_array:
        """((Φ_q ξ)_q η)_q for fixed directions ξ, η (nq,). Eqs. (40), (83), (91), (100).

        Returns
        -------
        csr_array (m, nq)
        """
        return self._evaluate("Phi_q_xi_q_eta_q", out, b, q=q, xi=xi, eta=eta, t=t)

    def Phi_qT_lam(
        self, q: ArrayLike, lam: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None
    ) -> Array:
        """Constraint force Φ_qᵀλ on the left side of the equations of motion, λ (m,). Eqs. (1), (43).

        Returns
        -------
        ndarray (nq,)
        """
        return self._vector_of("Phi_qT_lam", out, b, q=q, lam=lam, t=t)

    def Phi_qT_lam_q(
        self, q: ArrayLike, lam: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None
    ) -> csr_array:
        """(Φ_qᵀλ)_q for fixed multipliers, symmetric. Eqs. (44), (48), (86), (94), (103).

        Returns
        -------
        csr_array (nq, nq)
        """
        return self._evaluate("Phi_qT_lam_q", out, b, q=q, lam=lam, t=t)

    def Phi_qT_lam_q_xi_q(
        self, q: ArrayLike, lam: ArrayLike, xi: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None
    ) -> csr_array:
        """((Φ_qᵀλ)_q ξ)_q for fixed λ and ξ, symmetric; beyond the paper.

        Returns
        -------
        csr_array (nq, nq)
        """
        return self._evaluate("Phi_qT_lam_q_xi_q", out, b, q=q, lam=lam, xi=xi, t=t)

    def Phi_t(self, q: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None) -> Array:
        """Φ_t, so that consistent velocities have Φ_q v = -Φ_t. Eq. (3).

        Returns
        -------
        ndarray (m,)
        """
        return self._vector_of("Phi_t", out, b, q=q, t=t)

    def Phi_tt(self, q: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None) -> Array:
        """Φ_tt. Eq. (4).

        Returns
        -------
        ndarray (m,)
        """
        return self._vector_of("Phi_tt", out, b, q=q, t=t)

    def Phi_q_xi_t(
        self, q: ArrayLike, xi: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None
    ) -> Array:
        """(Φ_q ξ)_t = Φ_tq ξ. Eq. (4).

        Returns
        -------
        ndarray (m,)
        """
        return self._vector_of("Phi_q_xi_t", out, b, q=q, xi=xi, t=t)

    def Phi_t_b(self, q: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None) -> csr_array:
        """(Φ_t)_b.

        Returns
        -------
        csr_array (m, nb)
        """
        return self._evaluate("Phi_t_b", out, b, q=q, t=t)

    def gamma(self, q: ArrayLike, v: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None) -> Array:
        """Right-hand side of Φ_q a = γ = -(Φ_q v)_q v - 2 Φ_tq v - Φ_tt. Eq. (4).

        Returns
        -------
        ndarray (m,)
        """
        return self._vector_of("gamma", out, b, q=q, v=v, t=t)

    def gamma_q(
        self, q: ArrayLike, v: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None
    ) -> csr_array:
        """γ_q = -((Φ_q v)_q v)_q - 2 (Φ_tq v)_q - Φ_ttq. Eqs. (49), (84), (92), (101), which give its negative.

        Returns
        -------
        csr_array (m, nq)
        """
        return self._evaluate("gamma_q", out, b, q=q, v=v, t=t)

    def gamma_v(
        self, q: ArrayLike, v: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None
    ) -> csr_array:
        """γ_v = -2 (Φ_q v)_q - 2 Φ_tq. Eqs. (42), (50), (85), (93), (102), which give its negative.

        Returns
        -------
        csr_array (m, nq)
        """
        return self._evaluate("gamma_v", out, b, q=q, v=v, t=t)

    def Phi_b(self, q: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None) -> csr_array:
        """Φ_b: derivative with respect to all parameters of all elements, in the order of `parameter_names`.

        Returns
        -------
        csr_array (m, nb)
        """
        return self._evaluate("Phi_b", out, b, q=q, t=t)

    def Phi_q_xi_b(
        self, q: ArrayLike, xi: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None
    ) -> csr_array:
        """(Φ_q ξ)_b for a fixed direction ξ.

        Returns
        -------
        csr_array (m, nb)
        """
        return self._evaluate("Phi_q_xi_b", out, b, q=q, xi=xi, t=t)

    def Phi_q_xi_q_eta_b(
        self, q: ArrayLike, xi: ArrayLike, eta: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None
    ) -> csr_array:
        """((Φ_q ξ)_q η)_b for fixed directions ξ, η.

        Returns
        -------
        csr_array (m, nb)
        """
        return self._evaluate("Phi_q_xi_q_eta_b", out, b, q=q, xi=xi, eta=eta, t=t)

    def Phi_qT_lam_b(
        self, q: ArrayLike, lam: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None
    ) -> csr_array:
        """(Φ_qᵀλ)_b for fixed multipliers.

        Returns
        -------
        csr_array (nq, nb)
        """
        return self._evaluate("Phi_qT_lam_b", out, b, q=q, lam=lam, t=t)

    def gamma_b(
        self, q: ArrayLike, v: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None
    ) -> csr_array:
        """γ_b = -((Φ_q v)_q v)_b - 2 ((Φ_q v)_t)_b - (Φ_tt)_b.

        Returns
        -------
        csr_array (m, nb)
        """
        return self._evaluate("gamma_b", out, b, q=q, v=v, t=t)
