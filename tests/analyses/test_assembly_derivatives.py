"""Derivatives of assembled q and v against extrapolated differences of whole assemblies, and against themselves."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from tests.analyses.driven import turned
from tests.analyses.linkages import door, four_bar
from tests.analyses.rough import rough
from tests.system.mechanisms import hmmwv, slider_crank

import sarrus as sr
from sarrus.analyses.position.joint_space import held_coordinates

pytestmark = pytest.mark.filterwarnings("ignore::sarrus.SarrusWarning")  # random velocities are projected


def driven_pendulum() -> sr.System:
    """Two bodies on ball joints; one point is drawn near by a cylinder, one turns as prescribed: 4 freedoms."""
    one = sr.Body("one", 2.0, (0.02, 0.18, 0.19), position=(0.5, 0, 0))
    two = sr.Body("two", 1.5, (0.015, 0.09, 0.1), position=(1.3, 0.1, -0.2))
    joints = [
        sr.Spherical("shoulder", sr.ground, one, point=(0, 0, 0)),
        sr.Universal("elbow", one, two, point=(1, 0, 0), axis_i=(0, 1, 0), axis_j=(0, 0, 1)),
    ]
    anchor, eye = sr.ground.point(0.3, 0.2, 0.9), two.point(0.1, 0, 0.05)
    drivers = [
        sr.DistanceDriver("cylinder", anchor, eye, "1.4 + 0.2*sin(3*t)"),
        sr.AngleDriver("motor", "elbow.angle_i", "0.5*t**2"),
    ]
    return sr.System(sr.Model("driven pendulum", [one, two], joints, drivers=drivers))


def driven_slider_crank() -> sr.System:
    """No freedom is left: the angle of the crank is prescribed."""
    return turned(2.0, 1.0)


DRIVEN = [  # by two drivers, whose kernels are compiled for these cases alone
    (driven_pendulum, {"t": 0.3}),
    (driven_pendulum, {"t": 0.3, "metric": "mass", "rates": {"two.y": 0.4}}),
    (driven_pendulum, {"t": 0.3, "rates": {"elbow.angle_j": 0.7}}),
]
CASES = [
    (driven_slider_crank, {"t": 0.3}),
    (slider_crank, {}),
    (slider_crank, {"rates": {"pin": 2.0}}),
    (slider_crank, {"rates": {"guide": 1.0}, "metric": "mass"}),
    (slider_crank, {"fixed": ["slider.x"]}),
    (hmmwv, {}),
    (hmmwv, {"fixed": ["chassis"]}),
    (hmmwv, {"rates": {"rev_UCA_front_right": 0.5}}),
]


def richardson(function: Callable[[float], np.ndarray], step: float, levels: int = 4) -> np.ndarray:
    """The derivative at 0 by central differences, extrapolated to order 2 * levels."""
    steps = [step / 2**k for k in range(levels)]
    table = [(function(h) - function(-h)) / (2 * h) for h in steps]
    for order in range(1, levels):
        table = [(4**order * fine - rough) / (4**order - 1) for rough, fine in pairwise(table)]
    return table[0]


class Case:
    """A system, a guess off its constraints, and the assembly of both."""

    def __init__(self, make: Callable[[], sr.System], options: dict) -> None:
        self.system, self.options, self.random = make(), options, np.random.default_rng(11)
        self.t = options.get("t", 0.0)
        held = held_coordinates(self.system, options.get("fixed", ()))
        self.q = np.where(held, self.system.q0, rough(self.system, self.random, 0.1, 10))
        self.v = np.where(held, 0.0, self.random.normal(size=self.system.nq))
        self.found = self.assembled()
        assert self.found.asked is not None
        if options.get("metric") == "mass":  # constant in derivatives
            self.options = {**options, "metric": self.found.asked.weight}
        self.exact = sr.AssemblyDerivatives(self.system, self.found)

    def assembled(self, dq: object = 0.0, dv: object = 0.0) -> sr.Assembly:
        found = sr.assemble(self.system, self.q + dq, self.v + dv, **self.options)
        assert found.success, found.message
        assert found.nearest
        return found

    def with_numbers(self, db: np.ndarray) -> np.ndarray:
        numbers = self.system.b
        self.system.b = numbers + db
        try:
            found = self.assembled()
        finally:
            self.system.b = numbers
        return np.concatenate([found.q, found.v])

    def numbers(self) -> np.ndarray:
        """A direction of all numbers, but for those that only say where a motion's function is kept."""
        names = self.system.parameter_names
        design = np.array([not name.endswith(".motion") for name in names])
        db = np.zeros(len(self.system.b))
        db[: len(names)] = 0.1 * design * self.random.normal(size=len(names))
        return db


@pytest.fixture(
    params=[*(pytest.param(one, marks=pytest.mark.slow) for one in DRIVEN), *CASES],
    ids=lambda case: f"{case[0].__name__} {case[1]}",
    scope="module",
)
def case(request: pytest.FixtureRequest) -> Case:
    return Case(*request.param)


@pytest.mark.one_in(4)
def test_against_extrapolated_differences(case: Case) -> None:
    db = case.numbers()
    q_dot, v_dot = case.exact.along(db)
    want = richardson(lambda h: case.with_numbers(h * db), 1e-2)
    assert abs(db).max() > 0.1
    assert abs(q_dot).max() > 1e-3
    assert np.allclose(np.concatenate([q_dot, v_dot]), want, atol=1e-9, rtol=1e-9)


def test_the_constraints_stay_satisfied(case: Case) -> None:
    db, system, q, v, t = case.numbers(), case.system, case.found.q, case.found.v, case.t
    q_dot, v_dot = case.exact.along(db)
    numbers = db[: system.nb]
    assert np.allclose(system.Phi_q(q, t) @ q_dot + system.Phi_b(q, t) @ numbers, 0, atol=1e-10)
    moved = system.Phi_q_xi_q(q, v, t) @ q_dot + system.Phi_q_xi_b(q, v, t) @ numbers
    moved += system.Phi_t_b(q, t) @ numbers  # Φ_tq vanishes for all of our drivers
    assert np.allclose(system.Phi_q(q, t) @ v_dot + moved, 0, atol=1e-10)


@pytest.mark.one_in(8)
def test_columns_and_transposed_products_agree(case: Case) -> None:
    random, n = case.random, case.system.nq
    db, dv, q_bar, v_bar = case.numbers(), random.normal(size=n), random.normal(size=n), random.normal(size=n)
    dq = tangent(case, random.normal(size=n))
    q_b, v_b = case.exact.columns()
    assert np.allclose(q_b @ db, case.exact.q_b(db), atol=1e-11)
    assert np.allclose(v_b @ db, case.exact.v_b(db), atol=1e-11)
    q_dot, v_dot = case.exact.along(db, dq=dq, dv=dv)
    by_b, by_q, by_v = case.exact.gradient(q_bar, v_bar)
    assert q_bar @ q_dot + v_bar @ v_dot == pytest.approx(by_b @ db + by_q @ dq + by_v @ dv, abs=1e-10)


def tangent(case: Case, dq: np.ndarray) -> np.ndarray:
    """A change of the guess that keeps Euler parameters at unit length."""
    assert case.found.asked is not None
    p, d = case.found.asked.q.reshape(-1, 7)[:, 3:], dq.reshape(-1, 7)[:, 3:]
    d -= p * np.sum(p * d, axis=1, keepdims=True)
    return dq


def test_derivatives_to_the_guess() -> None:
    case = Case(slider_crank, {"rates": {"pin": 2.0}})
    case.q = case.found.asked.q
    dq, dv = tangent(case, case.random.normal(size=21)), case.random.normal(size=21)

    def moved(h: float) -> np.ndarray:
        found = case.assembled(h * dq, h * dv)
        return np.concatenate([found.q, found.v])

    exact = np.concatenate(case.exact.along(dq=dq, dv=dv))
    assert np.allclose(exact, richardson(moved, 1e-2), atol=1e-9)


def test_redundant_equations_must_stay_consistent() -> None:
    """Both hinges of a door may move up together, but not one alone."""
    system = door()
    exact = sr.AssemblyDerivatives(system, sr.assemble(system))
    upper, lower = (
        np.array([name == f"hinge_{n}[point].s_j.z" for name in system.parameter_names], dtype=float)
        for n in (2, 1)
    )
    rise = exact.q_b(upper + lower)
    assert np.allclose(rise[:3], [0, 0, -1], atol=1e-10)
    with pytest.raises(sr.NoDerivative, match="hinge"):
        exact.q_b(upper)
    columns = exact.columns()[0]
    assert np.all(np.isnan(columns[:, upper == 1]))
    assert np.all(np.isfinite(columns[:, [name == "panel[inertia].mass" for name in system.parameter_names]]))


def test_redundant_system_has_derivatives() -> None:
    """A planar four-bar has three redundant equations; its mass and its in-plane lengths may change."""
    system = four_bar(1.0, 3.0, 2.5, 3.2, 0.9)
    guess = system.q0 + 0.02 * np.random.default_rng(2).normal(size=21)
    exact = sr.AssemblyDerivatives(system, sr.assemble(system, guess))
    names = system.parameter_names
    db = np.array([name == "hinge_2[point].s_j.x" for name in names], dtype=float)
    q_dot = exact.q_b(db)
    assert abs(q_dot).max() > 0.1
    assert np.allclose(
        system.Phi_q(sr.assemble(system, guess).q) @ q_dot, -system.Phi_b(sr.assemble(system, guess).q) @ db
    )


def test_a_failed_assembly_has_no_derivatives() -> None:
    system = slider_crank()
    failed = sr.assemble(system, rates={"pin": 3.0, "slider.x": 5.0})
    with pytest.raises(ValueError, match="no velocity"):
        sr.AssemblyDerivatives(system, failed)
