"""The inertia operators of a system, by their public names."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from ...algebra import Array
from .operators import Operators


class InertiaOperators(Operators):
    """M, the quadratic velocity force S (right-hand side: M a + Φ_qᵀλ = Q + S), and their derivatives.

    Arguments, `b` and `out` as for the constraint operators. Rows of r in N, rows of p in N m.
    """

    def M(self, q: ArrayLike, *, b: Any = None, out: Any = None) -> csr_array:
        """Mass matrix M(q), symmetric, singular along each p: 4 GᵀJG has rank 3. Eq. (5).

        Returns
        -------
        csr_array (nq, nq)
        """
        return self._evaluate("M", out, b, q=q)

    def M_a(self, q: ArrayLike, a: ArrayLike, *, b: Any = None, out: Any = None) -> Array:
        """M a for an acceleration (or any vector) a (nq,), without forming M. Eq. (51), four times.

        Returns
        -------
        ndarray (nq,)
        """
        return self._vector_of("M_a", out, b, q=q, a=a)

    def M_a_q(self, q: ArrayLike, a: ArrayLike, *, b: Any = None, out: Any = None) -> csr_array:
        """(M a)_q for a fixed a. Eq. (56), four times.

        Returns
        -------
        csr_array (nq, nq)
        """
        return self._evaluate("M_a_q", out, b, q=q, a=a)

    def M_a_b(self, q: ArrayLike, a: ArrayLike, *, b: Any = None, out: Any = None) -> csr_array:
        """(M a)_b: derivative with respect to mass, inertia components and centre of mass.

        Returns
        -------
        csr_array (nq, nb)
        """
        return self._evaluate("M_a_b", out, b, q=q, a=a)

    def S(self, q: ArrayLike, v: ArrayLike, *, b: Any = None, out: Any = None) -> Array:
        """Quadratic velocity (gyroscopic) force S(q, v) on the right-hand side. Eq. (5).

        Returns
        -------
        ndarray (nq,)
        """
        return self._vector_of("S", out, b, q=q, v=v)

    def S_q(self, q: ArrayLike, v: ArrayLike, *, b: Any = None, out: Any = None) -> csr_array:
        """S_q. Eq. (57), eight times.

        Returns
        -------
        csr_array (nq, nq)
        """
        return self._evaluate("S_q", out, b, q=q, v=v)

    def S_v(self, q: ArrayLike, v: ArrayLike, *, b: Any = None, out: Any = None) -> csr_array:
        """S_v. Eq. (58), eight times, with its sign corrected.

        Returns
        -------
        csr_array (nq, nq)
        """
        return self._evaluate("S_v", out, b, q=q, v=v)

    def S_b(self, q: ArrayLike, v: ArrayLike, *, b: Any = None, out: Any = None) -> csr_array:
        """S_b: derivative with respect to mass, inertia components and centre of mass.

        Returns
        -------
        csr_array (nq, nb)
        """
        return self._evaluate("S_b", out, b, q=q, v=v)

    def M_a_q_xi_q(
        self, q: ArrayLike, a: ArrayLike, xi: ArrayLike, *, b: Any = None, out: Any = None
    ) -> csr_array:
        """((M a)_q ξ)_q for a fixed direction ξ, by differentiating the elements' own formulas.

        Returns
        -------
        csr_array (nq, nq)
        """
        return self._evaluate("M_a_q_xi_q", out, b, q=q, a=a, xi=xi)

    def S_q_xi_q(
        self, q: ArrayLike, xi: ArrayLike, v: ArrayLike, *, b: Any = None, out: Any = None
    ) -> csr_array:
        """(S_q ξ)_q for a fixed direction ξ, by differentiating the elements' own formulas.

        Returns
        -------
        csr_array (nq, nq)
        """
        return self._evaluate("S_q_xi_q", out, b, q=q, xi=xi, v=v)

    def S_q_xi_v(
        self, q: ArrayLike, xi: ArrayLike, v: ArrayLike, *, b: Any = None, out: Any = None
    ) -> csr_array:
        """(S_q ξ)_v for a fixed direction ξ, by differentiating the elements' own formulas.

        Returns
        -------
        csr_array (nq, nq)
        """
        return self._evaluate("S_q_xi_v", out, b, q=q, xi=xi, v=v)

    def S_v_xi_q(
        self, q: ArrayLike, xi: ArrayLike, v: ArrayLike, *, b: Any = None, out: Any = None
    ) -> csr_array:
        """(S_v ξ)_q for a fixed direction ξ, by differentiating the elements' own formulas.

        Returns
        -------
        csr_array (nq, nq)
        """
        return self._evaluate("S_v_xi_q", out, b, q=q, xi=xi, v=v)

    def S_v_xi_v(
        self, q: ArrayLike, xi: ArrayLike, v: ArrayLike, *, b: Any = None, out: Any = None
    ) -> csr_array:
        """(S_v ξ)_v for a fixed direction ξ, by differentiating the elements' own formulas.

        Returns
        -------
        csr_array (nq, nq)
        """
        return self._evaluate("S_v_xi_v", out, b, q=q, xi=xi, v=v)

    def kinetic_energy(self, q: ArrayLike, v: ArrayLike, *, b: Any = None) -> float:
        """T = ½ vᵀ M v [J]."""
        momentum, moving = self.M_a(q, v, b=b), self.moving
        return 0.5 * float(momentum[:moving] @ self._operand("v", v)[:moving])


class ForceOperators(Operators):
    """The generalized applied force Q(q, v, t) and its derivatives.

    Arguments, `b` and `out` as for the constraint operators; t in s. Rows of r in N, rows of p in N m.
    """

    def Q(self, q: ArrayLike, v: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None) -> Array:
        """Generalized force of gravity, loads, springs and tyres. Eqs. (63), (104), (105).

        Returns
        -------
        ndarray (nq,)
        """
        return self._vector_of("Q", out, b, q=q, v=v, t=t)

    def Q_q(self, q: ArrayLike, v: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None) -> csr_array:
        """Q_q. Eqs. (64)-(72), (107).

        Returns
        -------
        csr_array (nq, nq)
        """
        return self._evaluate("Q_q", out, b, q=q, v=v, t=t)

    def Q_v(self, q: ArrayLike, v: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None) -> csr_array:
        """Q_v. Eqs. (73)-(79), (108).

        Returns
        -------
        csr_array (nq, nq)
        """
        return self._evaluate("Q_v", out, b, q=q, v=v, t=t)

    def Q_b(self, q: ArrayLike, v: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None) -> csr_array:
        """Q_b: derivative with respect to all parameters of all forces.

        Returns
        -------
        csr_array (nq, nb)
        """
        return self._evaluate("Q_b", out, b, q=q, v=v, t=t)

    def Q_q_xi_q(
        self, q: ArrayLike, xi: ArrayLike, v: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None
    ) -> csr_array:
        """(Q_q ξ)_q for a fixed direction ξ, by differentiating the elements' own formulas.

        Returns
        -------
        csr_array (nq, nq)
        """
        return self._evaluate("Q_q_xi_q", out, b, q=q, xi=xi, v=v, t=t)

    def Q_q_xi_v(
        self, q: ArrayLike, xi: ArrayLike, v: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None
    ) -> csr_array:
        """(Q_q ξ)_v for a fixed direction ξ, by differentiating the elements' own formulas.

        Returns
        -------
        csr_array (nq, nq)
        """
        return self._evaluate("Q_q_xi_v", out, b, q=q, xi=xi, v=v, t=t)

    def Q_v_xi_q(
        self, q: ArrayLike, xi: ArrayLike, v: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None
    ) -> csr_array:
        """(Q_v ξ)_q for a fixed direction ξ, by differentiating the elements' own formulas.

        Returns
        -------
        csr_array (nq, nq)
        """
        return self._evaluate("Q_v_xi_q", out, b, q=q, xi=xi, v=v, t=t)

    def Q_v_xi_v(
        self, q: ArrayLike, xi: ArrayLike, v: ArrayLike, t: float = 0.0, *, b: Any = None, out: Any = None
    ) -> csr_array:
        """(Q_v ξ)_v for a fixed direction ξ, by differentiating the elements' own formulas.

        Returns
        -------
        csr_array (nq, nq)
        """
        return self._evaluate("Q_v_xi_v", out, b, q=q, xi=xi, v=v, t=t)
