"""The force operators of a system, by their public names."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from ...algebra import Array
from .operators import Operators


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
