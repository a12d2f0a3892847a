"""Sparse LU factorizations of the Newton matrices of implicit simulation: ours, SuperLU, KLU if installed, LAPACK.

    python benchmarks/linear.py [--json] [--quick]

Times in microseconds: the analysis with the first factorization, one more factorization of the same pattern, a
solution, and one with the transposed matrix, medians of interleaved rounds; and the largest error of a solution that
should be 1. KLU by the package nbklu.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

import sarrus as sr
from sarrus import mechanisms
from sarrus.analyses.dynamics.methods.tables import structure_of, tables_of
from sarrus.analyses.equations.motion import EquationsOfMotion
from sarrus.analyses.sensitivity.steps.matrix import OperationMatrix
from sarrus.analyses.sensitivity.steps.record import Occurrences
from sarrus.linalg.sparse_solver import SparseLU

sys.path.insert(0, str(Path(__file__).parent))
from chain import chain

Actions = dict[str, Callable[[], Any]]


def newton_matrix_of(system: sr.System) -> csc_array:
    """That of HHT at the start, for a step of 1 ms."""
    q, v = system.q0.copy(), np.zeros(system.nq)
    a, lam = EquationsOfMotion(system).acceleration(0.0, q, v)
    operation = sr.HHT().description.operation(np.array([1e-3]), np.ones(1))
    tables, none = tables_of(system, structure_of(operation)), np.zeros(0)
    weights = Occurrences(operation, tables, np.zeros(1, int), none, none, {}).weights(tables.weights)[0]
    matrix = OperationMatrix(system, tables)
    stage = {"t": 0.0, "q": q, "v": v, "a": a, "lam": lam}
    matrix.evaluate(system.b, np.zeros(system.m), [stage], weights)
    found = matrix.pattern()
    found.data = matrix.assembled()
    return found


def ours(A: csc_array, right: np.ndarray) -> Actions:
    lu = SparseLU(A.indptr, A.indices, A.data)
    return {
        "first": lambda: SparseLU(A.indptr, A.indices, A.data),
        "again": lambda: lu.factor(A.data),
        "solve": lambda: lu.solve(right),
        "transposed": lambda: lu.solve_transposed(right),
    }


def superlu(A: csc_array, right: np.ndarray) -> Actions:
    lu = splu(A)
    again = lambda: splu(A)  # noqa: E731
    return {
        "first": again,
        "again": again,
        "solve": lambda: lu.solve(right),
        "transposed": lambda: lu.solve(right, "T"),
    }


def klu(A: csc_array, right: np.ndarray) -> Actions:
    import nbklu

    places = A.indptr.astype(np.int32), A.indices.astype(np.int32)

    def fresh() -> Any:
        solver = nbklu.KLUSolver32Real()
        solver.analyze(A.shape[0], *places)
        solver.factor(A.data)
        return solver

    lu = fresh()
    return {
        "first": fresh,
        "again": lambda: lu.refactor(A.data),
        "solve": lambda: lu.solve(right),
        "transposed": lambda: lu.tsolve(right),
    }


def lapack(A: csc_array, right: np.ndarray) -> Actions:
    dense = A.toarray()
    factors = lu_factor(dense)
    again = lambda: lu_factor(dense, check_finite=False)  # noqa: E731
    return {
        "first": again,
        "again": again,
        "solve": lambda: lu_solve(factors, right, check_finite=False),
        "transposed": lambda: lu_solve(factors, right, trans=1, check_finite=False),
    }


def timed(action: Callable[[], Any]) -> float:
    began = time.perf_counter()
    action()
    return 1e6 * (time.perf_counter() - began)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--quick", action="store_true", help="the shipped mechanisms, few rounds")
    given = parser.parse_args()
    subjects = {name: sr.load(mechanisms.path(name)) for name in ("slider_crank", "hmmwv")}
    subjects |= {} if given.quick else {f"chain_{n}": chain(n) for n in (100, 1000)}
    found: dict[str, float] = {}
    for name, model in subjects.items():
        A = newton_matrix_of(sr.System(model))
        right, rounds = A @ np.ones(A.shape[0]), 3 if given.quick else 9
        found[f"{name}.unknowns"], found[f"{name}.numbers"] = A.shape[0], A.nnz
        solvers = {}
        for label, make in {"ours": ours, "superlu": superlu, "klu": klu, "lapack": lapack}.items():
            if label == "lapack" and A.shape[0] > 3000:
                continue
            try:
                solvers[label] = make(A, right)
            except ImportError:
                continue
        times: dict[str, list[float]] = {}
        for _ in range(rounds):
            for label, actions in solvers.items():
                for action, run in actions.items():
                    times.setdefault(f"{name}.{label}.{action}", []).append(timed(run))
        found |= {key: round(statistics.median(values), 1) for key, values in times.items()}
        for label, actions in solvers.items():
            found[f"{name}.{label}.error"] = float(abs(actions["solve"]() - 1).max())
    print(
        json.dumps(found, indent=2) if given.json else "\n".join(f"{k:32s} {v:.4g}" for k, v in found.items())
    )


if __name__ == "__main__":
    main()
