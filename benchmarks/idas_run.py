"""The planar slider-crank of SUNDIALS by CasADi and IDAS: gradient of the integral of the kinetic energy, by adjoint.

For `sensitivity.py`, run by a Python that has CasADi. IDAS takes index-1 equations: accelerations and multipliers are
algebraic, M a + Φ_qᵀλ = Q, Φ_q a = γ.
"""

import json
import time
from pathlib import Path

import casadi as ca
import numpy as np

NAMES = ("a", "J1", "m2", "J2", "k", "c", "l0", "F")
VALUES = (0.5, 1.0, 1.0, 2.0, 1.0, 1.0, 1.0, 1.0)
UNTIL, RTOL = 10.0, 1e-6


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


def main() -> None:
    """Print time and error of run and gradient."""
    state, algebraic, p, rate, balance, energy = equations()
    dae = {"x": state, "z": algebraic, "p": p, "ode": rate, "alg": balance, "quad": energy}
    options = {"reltol": RTOL, "abstol": RTOL, "calc_ic": True, "quad_err_con": True, "max_num_steps": 100000}
    integrator = ca.integrator("crank", "idas", dae, 0.0, UNTIL, options)
    P = ca.MX.sym("p", 8)
    x0 = ca.vertcat(np.pi / 2, ca.sqrt(1 - P[0] ** 2), -ca.asin(P[0]), 0, 0, 0)
    G = integrator(x0=x0, p=P, z0=np.zeros(5))["qf"]
    gradient = ca.Function("gradient", [P], [G, ca.gradient(G, P)])
    gradient(VALUES)
    times = []
    for _ in range(5):
        began = time.perf_counter()
        _, found = gradient(VALUES)
        times.append(time.perf_counter() - began)
    file = Path(__file__).resolve().parent.parent / "tests/reference/S04_sundials_slider_crank.json"
    told = json.loads(file.read_text())["grad"]["G"]
    wanted = np.array([told[name] for name in NAMES])
    error = abs(np.array(found).reshape(-1) - wanted).max() / abs(wanted).max()
    print(json.dumps({"run_and_gradient_s": min(times), "gradient_error": float(error)}))


if __name__ == "__main__":
    main()
