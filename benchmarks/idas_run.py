"""The planar slider-crank of SUNDIALS by CasADi and IDAS: gradient of the integral of the kinetic energy.

For `sensitivity.py` and `sensitivity_beside.py`, run by a Python that has CasADi. IDAS takes index-1 equations:
accelerations and multipliers are algebraic, M a + Φ_qᵀλ = Q, Φ_q a = γ. Both ways that it has: sensitivities
integrated forward with the motion, one system more for each number, and the adjoint system integrated backward.

    python benchmarks/idas_run.py [--table]
"""

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

NAMES = ("a", "J1", "m2", "J2", "k", "c", "l0", "F")
VALUES = (0.5, 1.0, 1.0, 2.0, 1.0, 1.0, 1.0, 1.0)
UNTIL, RTOL = 10.0, 1e-6
TABLE = (1e-4, 1e-6, 1e-8, 1e-10)


def equations() -> tuple[ca.SX, ca.SX, ca.SX, ca.SX, ca.SX]:
    """State (q, v), algebraic (acceleration, multipliers), parameters, rate, algebraic equations, kinetic energy."""
    y, w, acc, lam, p = (ca.SX.sym(n, k) for n, k in (("y", 3), ("w", 3), ("acc", 3), ("lam", 2), ("p", 8)))
    a, J1, m2, J2, k, c, l0, F = ca.vertsplit(p)
    q, x, r = ca.vertsplit(y)
    Phi = ca.vertcat(x - ca.cos(r) - a * ca.cos(q), -ca.sin(r) - a * ca.sin(q))
    Phi_q = ca.jacobian(Phi, y)
    square = x**2 - x * (ca.cos(r) + a * ca.cos(q)) + (1 + a**2) / 4 + a * ca.cos(r - q) / 2
    length = ca.sqrt(square)
    rate = ca.jtimes(length, y, w)
    force = k * (length - l0) + c * rate
    Q = -force * ca.gradient(length, y) + F * ca.vertcat(0, 1, -ca.sin(r))
    M = ca.diag(ca.vertcat(J1, m2, J2))
    gamma = -ca.jtimes(ca.mtimes(Phi_q, w), y, w)
    balance = ca.vertcat(ca.mtimes(M, acc) + ca.mtimes(Phi_q.T, lam) - Q, ca.mtimes(Phi_q, acc) - gamma)
    energy = 0.5 * ca.dot(w, ca.mtimes(M, w))
    return ca.vertcat(y, w), ca.vertcat(acc, lam), p, ca.vertcat(w, acc), balance, energy


def functions(rtol: float) -> dict[str, Any]:
    """The integral as a function of the numbers, and it with its gradient, forward and by adjoint."""
    state, algebraic, p, rate, balance, energy = equations()
    dae = {"x": state, "z": algebraic, "p": p, "ode": rate, "alg": balance, "quad": energy}
    options = {
        "reltol": rtol,
        "abstol": rtol,
        "calc_ic": True,
        "quad_err_con": True,
        "max_num_steps": 1000000,
    }
    integrator = ca.integrator("crank", "idas", dae, 0.0, UNTIL, options)
    P = ca.MX.sym("p", 8)
    x0 = ca.vertcat(np.pi / 2, ca.sqrt(1 - P[0] ** 2), -ca.asin(P[0]), 0, 0, 0)
    G = integrator(x0=x0, p=P, z0=np.zeros(5))["qf"]
    return {
        "run": ca.Function("run", [P], [G]),
        "forward": ca.Function("forward", [P], [G, ca.jtimes(G, P, ca.MX.eye(8))]),
        "adjoint": ca.Function("adjoint", [P], [G, ca.gradient(G, P)]),
    }


def shortest(function: Callable[[], Any], repeats: int = 5) -> float:
    """The shortest of some processor times, after a first call. [s]"""
    times = []
    for _ in range(repeats + 1):
        began = time.process_time()
        function()
        times.append(time.process_time() - began)
    return min(times[1:])


def told() -> tuple[float, np.ndarray]:
    """The integral and its gradient in twelve digits."""
    file = Path(__file__).resolve().parent.parent / "tests/reference/S04_sundials_slider_crank.json"
    known = json.loads(file.read_text())
    return known["psi"]["G"], np.array([known["grad"]["G"][name] for name in NAMES])


def row(rtol: float, way: str) -> dict[str, Any]:
    """Times and errors of one way at one tolerance."""
    (value, wanted), ways = told(), functions(rtol)
    G, slopes = (np.array(found).reshape(-1) for found in ways[way](VALUES))
    return {
        "rtol": rtol,
        "way": way,
        "value_error": float(abs(G[0] - value)),
        "gradient_error": float(abs(slopes - wanted).max() / abs(wanted).max()),
        "run_s": shortest(lambda: ways["run"](VALUES)),
        "run_and_gradient_s": shortest(lambda: ways[way](VALUES)),
    }


def main() -> None:
    """Print time and error of run and gradient, as JSON; of all tolerances and both ways with --table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--table", action="store_true", help="all tolerances, forward and adjoint")
    if parser.parse_args().table:
        print(json.dumps([row(rtol, way) for way in ("forward", "adjoint") for rtol in TABLE]))
    else:
        found = row(RTOL, "adjoint")
        print(json.dumps({name: found[name] for name in ("run_and_gradient_s", "gradient_error")}))


if __name__ == "__main__":
    main()
