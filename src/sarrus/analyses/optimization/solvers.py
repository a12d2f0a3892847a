"""Solvers of nonlinear programs: those of SciPy, and IPOPT if it is installed."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from ...model import SarrusError
from .search import Search

SCIPY = ("L-BFGS-B", "SLSQP", "trust-constr")
SOLVERS = (*SCIPY, "IPOPT")
CURVED = ("trust-constr", "IPOPT")  # those that take second derivatives
IPOPT_DONE = {0: "solved to the tolerance", 1: "solved to an acceptable level"}
IPOPT_ELSE = {
    2: "the constraints cannot all be satisfied near here",
    -1: "the number of iterations is used up",
}

WORDS = {  # by parts of SciPy's messages
    "projected gradient": "converged: the gradient is zero as far as bounds allow",
    "gtol": "converged: the gradient is zero as far as bounds allow",
    "reduction of f": "converged: the objective no longer decreases",
    "ftol": "converged: the objective no longer decreases",
    "xtol": "converged: the steps have become small",
    "terminated successfully": "converged: the optimality conditions hold",
    "iteration": "the number of iterations is used up",
    "function evaluations is exceeded": "the number of simulations is used up",
    "abnormal": "the line search found no better design",
    "positive directional derivative": "the line search found no better design",
}


class Answer(NamedTuple):
    """Whether a solver reports convergence, its message, and the iterations that it took.

    `status` is given where the search was ended from outside: "stopped" or "time limit".
    """

    success: bool
    message: str
    iterations: int = 0
    status: str = ""


def solver_of(
    name: str | None, constrained: bool, second_order: bool = False
) -> Callable[[Search, int, float], Answer]:
    """Return the solver of a name; by default L-BFGS-B, or SLSQP with constraints.

    Raises
    ------
    ValueError
        If the name is unknown, if L-BFGS-B is combined with constraints, or if a solver cannot use second derivatives.
    """
    chosen = name or ("SLSQP" if constrained else "L-BFGS-B")
    if chosen not in SOLVERS:
        raise ValueError(f"there is no solver {chosen!r}. Choose from {', '.join(SOLVERS)}.")
    if constrained and chosen == "L-BFGS-B":
        raise ValueError("L-BFGS-B does not support constraints. Choose SLSQP, trust-constr or IPOPT.")
    if second_order and chosen not in CURVED:
        raise ValueError(f"{chosen} does not use second derivatives. Choose {' or '.join(CURVED)}.")
    if chosen == "IPOPT":
        return lambda search, iterations, tolerance: by_ipopt(search, iterations, tolerance, second_order)
    return lambda search, iterations, tolerance: by_scipy(search, chosen, iterations, tolerance, second_order)


def by_scipy(
    search: Search, method: str, iterations: int, tolerance: float, second_order: bool = False
) -> Answer:
    """Solve by `scipy.optimize.minimize`, with the objective of `Search.normalize`."""
    from scipy.optimize import Bounds, minimize

    def accepted(z: Array, *_: Any) -> None:
        search.iterate(z)

    low, high = search.variables.ends.T
    bounds = Bounds(low, high, keep_feasible=method == "trust-constr")
    bounds = bounds if np.isfinite([low, high]).any() else None
    with warnings.catch_warnings():
        # at a wall constraints do not change
        warnings.filterwarnings("ignore", "delta_grad == 0.0", UserWarning)
        result = minimize(
            search.scaled_value, search.variables.z0, jac=search.scaled_slope,
            method=method, bounds=bounds, constraints=_constraints(search, second_order), tol=tolerance,
            callback=accepted, options={"maxiter": iterations},
            hessp=(lambda z, p: search.curved(z, p) / search.size) if second_order else None,
        )  # fmt: skip
    return Answer(bool(result.success), in_words(str(result.message)), int(result.nit))


def in_words(message: str) -> str:
    """Return the message that replaces SciPy's."""
    plain = message.rstrip(".").replace("`", "").lower()
    return next((words for mark, words in WORDS.items() if mark in plain), plain)


def _constraints(search: Search, second_order: bool) -> Any:
    """Return all constraints as one vector of responses, each divided by its size."""
    from scipy.optimize import BFGS, NonlinearConstraint
    from scipy.sparse.linalg import LinearOperator

    if not search.constraints:
        return ()
    size = np.array([constraint.size for constraint in search.constraints])
    low, high = np.array([constraint.ends for constraint in search.constraints]).T / size

    def curved(z: Array, multipliers: Array) -> Any:
        others = np.asarray(multipliers) / size
        return LinearOperator((len(z), len(z)), matvec=lambda p: search.curved(z, np.ravel(p), 0.0, others))

    return NonlinearConstraint(
        lambda z: search.others(z) / size, low, high, jac=lambda z: search.other_slopes(z) / size[:, None],
        hess=curved if second_order else BFGS(),
    )  # fmt: skip


def by_ipopt(search: Search, iterations: int, tolerance: float, second_order: bool = False) -> Answer:
    """Solve by IPOPT, an interior-point method, with exact Hessians of the Lagrangian or its own quasi-Newton ones.

    Raises
    ------
    SarrusError
        If it is not installed.
    """
    try:
        import ipyopt
    except ImportError:
        raise SarrusError(
            'solver: IPOPT is not installed. Install it with: pip install "sarrus[ipopt]".'
        ) from None
    n, m = len(search.variables.names), len(search.constraints)
    size = np.array([constraint.size for constraint in search.constraints])
    low, high = np.clip(search.variables.ends.T, -1e20, 1e20)  # beyond 1e19 is infinite to IPOPT
    ends = np.array([constraint.ends for constraint in search.constraints]).reshape(-1, 2).T / size
    rows, columns = (np.ravel(x) for x in np.indices((m, n)))
    triangle = np.tril_indices(n)

    def curvature(z: Array, multipliers: Array, objective: float, out: Array) -> Array:
        whole = search.curvature(z, objective / search.size, multipliers / size)
        return _put(out, whole[triangle])

    problem = ipyopt.Problem(
        n, low.copy(), high.copy(), m, np.clip(ends[0], -1e20, 1e20), np.clip(ends[1], -1e20, 1e20),
        (rows, columns), triangle,
        search.scaled_value,
        lambda z, out: _put(out, search.scaled_slope(z)),
        lambda z, out: _put(out, search.others(z) / size if m else np.zeros(0)),
        lambda z, out: _put(out, np.ravel(search.other_slopes(z) / size[:, None]) if m else np.zeros(0)),
        curvature if second_order else None,
        intermediate_callback=lambda *report: True,
    )  # fmt: skip
    problem.set(
        max_iter=iterations, tol=tolerance, print_level=0, sb="yes",
        hessian_approximation="exact" if second_order else "limited-memory",
    )  # fmt: skip
    _, _, status = problem.solve(search.variables.z0.copy())
    messages = IPOPT_DONE | IPOPT_ELSE
    return Answer(status in IPOPT_DONE, messages.get(status, f"IPOPT ended with status {status}"))


def _put(out: Array, values: Array) -> Array:
    out[()] = values
    return out
