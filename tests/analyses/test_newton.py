"""Newton's method with the matrices of the implicit methods converges quadratically, and not if any term is missing."""

from collections.abc import Callable, Mapping
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from tests.analyses.test_descriptions import OWN

import sarrus as sr
from sarrus.analyses.dynamics.integrators.alpha import generalized_alpha
from sarrus.analyses.dynamics.methods.collocation import RADAU
from sarrus.analyses.dynamics.methods.tables import structure_of, tables_of
from sarrus.analyses.equations.length import kinematic_weights
from sarrus.analyses.equations.motion import EquationsOfMotion
from sarrus.analyses.sensitivity.steps.matrix import OperationMatrix
from sarrus.analyses.sensitivity.steps.record import Occurrences
from sarrus.linalg.sparse_solver import SingularMatrix

pytestmark = pytest.mark.filterwarnings("ignore:.*assembly changed")  # states here are drawn roughly

H = 0.05


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
    return start.q, start.v, *EquationsOfMotion(top()).acceleration(0.0, start.q, start.v)


def unbalanced(q: np.ndarray, v: np.ndarray, a: np.ndarray, lam: np.ndarray) -> np.ndarray:
    """M a + Φ_qᵀλ - Q - S."""
    system = top()
    return system.M_a(q, a) + system.Phi_qT_lam(q, lam) - system.Q(q, v) - system.S(q, v)


UNITS = {"Q": 1.0, "V": H, "A": H * H}  # of unknowns, by the first letters of their names


def described_steps(method: sr.Description, without: str = "") -> list[float]:
    """Sizes of the Newton steps of one step of a description, from a disturbed guess, with the matrix of the sweeps."""
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
        moved = [UNITS[n[0]] * change[at:][: system.nq] for n, at in tables.unknowns.items() if n[0] in UNITS]
        sizes.append(float(np.linalg.norm(np.concatenate(moved))))
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
    return described_steps(OWN["implicit_midpoint"].description, without)


def bdf2_steps(without: str = "") -> list[float]:
    return described_steps(OWN["bdf2"].description, without)


def alpha_steps(without: str = "") -> list[float]:
    return described_steps(sr.HHT().description, without)


def radau_steps(without: str = "") -> list[float]:
    return described_steps(RADAU, without)


DESCRIBED = ("M@", "M_a_q", "S_q", "S_v", "Q_q", "Q_v", "Phi_qT_lam_q", "gamma_v")
CASES = [
    *((alpha_steps, term) for term in (*DESCRIBED[:-1], "Phi_q@0")),
    *((radau_steps, term) for term in (*DESCRIBED, "Phi_q@0", "Phi_q@2")),
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
