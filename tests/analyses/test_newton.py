"""Newton's method with the matrices of the implicit methods converges quadratically, and not if any term is missing."""

from collections.abc import Callable, Mapping
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from scipy.sparse.linalg import splu
from tests.analyses.test_descriptions import OWN

import sarrus as sr
from sarrus.analyses.dynamics.integrators.alpha import Scheme
from sarrus.analyses.dynamics.methods.generalized_alpha import generalized_alpha
from sarrus.analyses.dynamics.methods.tables import structure_of, tables_of
from sarrus.analyses.dynamics.stepping import newton_matrix
from sarrus.analyses.dynamics.stepping.stabilized_matrix import MATRICES, newton_parts, weigh
from sarrus.analyses.equations.block_matrix import LEFT_OUT, UNIT, Numbers, PlacedMatrix
from sarrus.analyses.equations.length import kinematic_weights
from sarrus.analyses.equations.motion import Motion
from sarrus.analyses.sensitivity.steps.matrix import OperationMatrix
from sarrus.analyses.sensitivity.steps.record import Occurrences
from sarrus.linalg.sparse_solver import SingularMatrix

pytestmark = pytest.mark.filterwarnings("ignore:.*assembly changed")  # states here are drawn roughly

H = 0.05
GROUPS = (("Phi_q", "Phi_qT_lam_q"), ("M", "M_a_q", "S_q", "S_v"), ("Q_q", "Q_v"))
TERMS = ("M", "M_a_q", "S_q", "S_v", "Q_q", "Q_v", "Phi_q", "Phi_qT_lam_q")


@cache
def top() -> sr.System:
    """A spinning top on a spring with a damper."""
    body = sr.Body(
        "top",
        2.0,
        (0.08, 0.1, 0.05),
        position=(0.1, 0.2, 0.4),
        velocity=(0.2, -1.1, 0.5),
        angular_velocity=(2, 1, 8),
    )
    spring = sr.TSDA("spring", sr.ground.point(1, 0, 1), body.point(0.3, 0.1, 0), k=80.0, c=5.0, length=1.0)
    tip = sr.Spherical("tip", sr.ground, body, point=(0, 0, 0))
    return sr.System(sr.Model("top", [body], joints=[tip], forces=[spring], gravity=(0, 0, -9.81)))


@cache
def moving() -> tuple[np.ndarray, ...]:
    """Its start, with everything in motion: q, v, a, lam."""
    start = sr.assemble(top())
    return start.q, start.v, *Motion(top()).acceleration(0.0, start.q, start.v)


def evaluate(views: dict[str, np.ndarray], without: str, **state: np.ndarray) -> None:
    """Write the operators' numbers at a state; those of the missing term are zero."""
    system = top()
    for names in GROUPS if "gamma_v" not in views else (*GROUPS, ("gamma_v",)):
        group = system.group(*names)
        operands = ({"t": 0.0, **state}[name] for name in group.operands)
        group.run(system.b, *operands, *(views[name] for name in names))
    if without:
        views[without][:] = 0.0


def end_of(scheme: Scheme, a: np.ndarray) -> tuple[np.ndarray, ...]:
    """q and v at the end of a step, without multipliers."""
    q0, v0, a0, _ = moving()
    x = (1 - scheme.alpha_f) * a + scheme.alpha_f * a0
    q = q0 + H * v0 + H * H * ((0.5 - scheme.beta) * a0 + scheme.beta * x)
    return q, v0 + H * ((1 - scheme.gamma) * a0 + scheme.gamma * x)


def weights_of(scheme: Scheme) -> tuple[float, float]:
    """β' and γ'."""
    kappa = (1 - scheme.alpha_f) / (1 - scheme.alpha_m)
    return scheme.beta * H * H * kappa, scheme.gamma * H * kappa


def unbalanced(q: np.ndarray, v: np.ndarray, a: np.ndarray, lam: np.ndarray) -> np.ndarray:
    """M a + Φ_qᵀλ - Q - S."""
    system = top()
    return system.M_a(q, a) + system.Phi_qT_lam(q, lam) - system.Q(q, v) - system.S(q, v)


def alpha_steps(without: str = "") -> list[float]:
    """Sizes of the Newton steps of one step of HHT, from a disturbed start."""
    system, (_, _, a0, lam), sizes = top(), moving(), list[float]()
    matrix, scheme = newton_matrix.newton_matrix(system), sr.HHT().scheme()
    a, views = a0 + 20 * np.cos(np.arange(7)), matrix.numbers.views
    beta, gamma = weights_of(scheme)
    for _ in range(7):
        q, v = end_of(scheme, a)
        evaluate(views, without, q=q, v=v, a=a, lam=lam)
        newton_matrix.weigh(matrix.weights, beta, gamma)
        matrix.choose_pivots()
        step = matrix.solve(np.concatenate([unbalanced(q, v, a, lam), system.Phi(q) / beta]))
        a, lam = a - step[: system.nq], lam - step[system.nq :]
        sizes.append(float(np.linalg.norm(beta * step[: system.nq])))
    return sizes


def described_steps(method: sr.Description, without: str = "") -> list[float]:
    """The same for one step of a description, from a disturbed guess, with its matrix as runs and sweeps take it."""
    system, (q0, v0, a0, lam0) = top(), moving()
    operation = method.operation(H, 1.0)
    step, tables = operation.step, tables_of(system, structure_of(operation))
    matrix, sizes = OperationMatrix(system, tables), list[float]()
    state = {"q": q0, "v": v0, "a": a0, "lam": lam0}
    state |= {name: value(by, state) for name, by in method.extra.items()}
    none = np.zeros(0)
    weights = Occurrences(operation, tables, np.zeros(1, int), none, none, {}).weights(tables.weights)[0]
    z = guessed(step, state)
    for _ in range(8):
        known = state | z
        stages = [
            {"t": stage.time * H}
            | {n: value(getattr(stage, n), known) for n in stage._fields[1:] if getattr(stage, n)}
            for stage in step.stages
        ]
        matrix.evaluate(system.b, np.zeros(system.m), stages, weights)
        for name, view in matrix.numbers.views.items():
            if without and name.startswith(without):
                view[:] = 0.0
        matrix.choose_pivots()
        right = [e.scale * equation(e.kind, stages[e.stage]) for e in step.equations]
        change = matrix.solve(np.concatenate(right))
        for name, at in tables.unknowns.items():
            z[name] = z[name] - change[at : at + len(z[name])]
        sizes.append(float(np.linalg.norm(change[tables.unknowns["Q"] :][: system.nq])))
    return sizes


def value(affine: Mapping[str, float], known: Mapping[str, np.ndarray]) -> np.ndarray:
    return np.asarray(sum(factor * known[name] for name, factor in affine.items()))


def guessed(step: sr.Step, state: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Unknowns by the quantities of stages that they alone determine, of a motion that is disturbed."""
    q, v, a, lam = (state[name] for name in ("q", "v", "a", "lam"))
    wave = np.cos(np.arange(len(q)))
    motion = {"q": q + H * v + 0.01 * wave, "v": v + H * a + 0.1 * wave, "a": a, "lam": lam, "mu": 0 * lam}
    quantities = [(getattr(stage, n), x) for stage in step.stages for n, x in motion.items()]
    alone = [(next(iter(by.items())), x) for by, x in quantities if len(by) == 1]
    return {name: x / factor for (name, factor), x in alone if name not in state}


def equation(kind: str, x: Mapping[str, np.ndarray]) -> np.ndarray:
    """The residual of an equation at a stage."""
    system, q = top(), x["q"]
    if kind == "motion":
        return unbalanced(q, x["v"], x["a"], x["lam"])
    if kind == "kinematic":
        return kinematic_weights(system) * x["rate"] + system.Phi_qT_lam(q, x["mu"])
    return system.Phi(q) if kind == "position" else system.Phi_q_xi(q, x["v"])


def stabilized_steps(without: str = "") -> list[float]:
    return described_steps(generalized_alpha(*sr.HHT().scheme(), stabilized=True), without)


def midpoint_steps(without: str = "") -> list[float]:
    return described_steps(OWN["implicit_midpoint"], without)


def bdf2_steps(without: str = "") -> list[float]:
    return described_steps(OWN["bdf2"], without)


def radau_steps(without: str = "") -> list[float]:
    """The same for a stage of the stabilized equations with the real matrix of Radau; its solution is known, μ = 0."""
    system, (q1, v1, a1, lam), s = top(), moving(), 1 / H
    nq, m, sizes = system.nq, system.m, list[float]()
    numbers = Numbers(system, (*MATRICES, UNIT, LEFT_OUT))
    matrix = PlacedMatrix(numbers, 2 * (nq + m), newton_parts(nq, m))
    q0, v0, wave = q1 - v1 / s, v1 - a1 / s, np.cos(np.arange(nq))
    q, v, mu = q1 + 0.01 * wave, v1 + 0.1 * wave, np.zeros(m)
    for _ in range(7):
        a = s * (v - v0)
        evaluate(numbers.views, without, q=q, v=v, a=a, lam=lam)
        weigh(matrix.weights, 1 / s**2, 1 / s)
        first = kinematic_weights(system) * (s * (q - q0) - v) + system.Phi_qT_lam(q, mu)
        rows = [first / s, unbalanced(q, v, a, lam) / s**2, system.Phi(q), system.Phi_q_xi(q, v) / s]
        place = matrix.pattern()
        place.data[:] = matrix.assembled()
        with np.errstate(all="ignore"):
            step = splu(place).solve(np.concatenate(rows))
        step *= np.repeat([1, s, s * s, s], [nq, nq, m, m])
        dq, dv, dlam, dmu = np.split(step, [nq, 2 * nq, 2 * nq + m])
        q, v, lam, mu = q - dq, v - dv, lam - dlam, mu - dmu
        sizes.append(float(np.linalg.norm(dq)))
    return sizes


DESCRIBED = ("M@", "M_a_q", "S_q", "S_v", "Q_q", "Q_v", "Phi_qT_lam_q", "gamma_v")
CASES = [
    *((alpha_steps, term) for term in TERMS),
    *((radau_steps, term) for term in (*TERMS, "gamma_v")),
    *((stabilized_steps, term) for term in (*DESCRIBED, "Phi_q@0", "Phi_q@1")),
    *((midpoint_steps, term) for term in (*DESCRIBED, "Phi_q@0", "Phi_q@1")),
    *((bdf2_steps, term) for term in (*DESCRIBED, "Phi_q@0")),
]


def quadratic(sizes: list[float]) -> bool:
    """Each step is at most ten times the square of the one before, down to round-off, which is reached."""
    return sizes[-1] < 1e-14 and all(after < 10 * before**2 + 1e-14 for before, after in pairwise(sizes))


@pytest.mark.parametrize("steps", [alpha_steps, radau_steps, stabilized_steps, midpoint_steps, bdf2_steps])
def test_quadratic_with_the_exact_matrix(steps: Callable[..., list[float]]) -> None:
    sizes = steps()
    assert sizes[0] > 0.01
    assert quadratic(sizes), sizes


@pytest.mark.parametrize(("steps", "term"), CASES)
def test_not_quadratic_without_a_term(steps: Callable[..., list[float]], term: str) -> None:
    """Each term of the matrix counts: M, (M q'')_q, (Φ_qᵀλ)_q, Q_q, Q_v, S_q, S_v, Φ_q, (Φ_q v)_q and Φ_q(q₀)."""
    try:
        sizes = steps(term)
    except (SingularMatrix, RuntimeError):
        return  # without M or Φ_q there may be no matrix
    assert not quadratic(sizes), sizes
