"""`equilibrium` against the potential energy, written down again and minimized by SciPy, and in any units."""

import numpy as np
import pytest
from scipy.optimize import minimize
from tests.verdicts.random_mechanisms import KINDS, Mechanism, mechanism

import sarrus as sr

UNITS = [(1e-6, 1e-9), (1e4, 1e6), (1e-6, 1e6), (1e4, 1e-9)]


def minimized(made: Mechanism, system: sr.System, q: np.ndarray) -> float:
    """The least potential energy near q on the constraints, by sequential quadratic programming."""
    rows = sr.mobility(system, q).independent_rows
    closed = {
        "type": "eq",
        "fun": lambda x: system.Phi(x)[rows],
        "jac": lambda x: system.Phi_q(x).toarray()[rows],
    }
    scale = abs(made.potential(q))
    found = minimize(
        lambda x: made.potential(x) / scale,
        q,
        jac=lambda x: made.gradient(x) / scale,
        constraints=[closed],
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 300},
    )
    assert abs(system.Phi(found.x)).max() < 1e-6
    return float(made.potential(found.x))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*assembly changed")
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("block", range(2))
def test_random_mechanisms(kind: str, block: int) -> None:
    for seed in range(25 * block, 25 * block + 25):
        made = mechanism(seed, kind)
        system = made.system()
        found = sr.equilibrium(system)
        assert found.success, (kind, seed, found.message)
        assert found.stability == "stable", (kind, seed, found.message)
        slope = made.gradient(found.q)
        J = system.Phi_q(found.q).toarray()
        lam = np.linalg.lstsq(J.T, -slope, rcond=None)[0]
        largest = max(abs(slope).max(), abs(J.T * lam).max())
        assert abs(slope + J.T @ lam).max() < 1e-8 * largest, (kind, seed)
        near = sr.assemble(system, found.q + 0.003 * np.random.default_rng(seed).normal(size=system.nq)).q
        least, here = minimized(made, system, near), float(made.potential(found.q))
        assert least == pytest.approx(here, abs=1e-7 * abs(here)), (kind, seed)
        length, mass = UNITS[seed % 4]
        other = sr.equilibrium(mechanism(seed, kind, length=length, mass=mass).system())
        assert (other.success, other.stability) == (True, "stable"), (kind, seed, other.message)
        assert np.allclose(other.squares, found.squares, rtol=1e-5), (kind, seed)


@pytest.mark.parametrize("mass", [1e-9, 1.0, 85.0, 1e6])
@pytest.mark.parametrize("k", [1e2, 1e4, 1e7])
@pytest.mark.parametrize("length", [1e-6, 1.0, 1e4])
def test_a_mass_on_a_spring(mass: float, k: float, length: float) -> None:
    """Where springs carry the weight on the same body, the net force is round-off: it is no measure of balance."""
    body = sr.Body("b", mass, (mass * length**2,) * 3, position=(0, 0, length))
    slide = sr.Translational("j", sr.ground, body, point=(0, 0, length), axis=(0, 0, 1))
    spring = sr.TSDA("s", sr.ground.point(0, 0, 0), body.point(0, 0, 0), k=k * mass, length=length)
    system = sr.System(sr.Model("m", [body], [slide], [spring], gravity=(0, 0, -9.81 * length)))
    found = sr.equilibrium(system)
    assert found.success, found.message
    assert found.stability == "stable"
    assert found.q[2] == pytest.approx(length * (1 - 9.81 / k), rel=1e-12)
    assert sr.modes(system, found.q).success


@pytest.mark.parametrize("far", [0.0, 1e3, 1e8])
def test_far_from_the_origin(far: float) -> None:
    """The same mechanism elsewhere; its positions have fewer digits there, and the verdict knows."""
    where = np.array([far, -far, 0.5 * far])
    body = sr.Body("b", 2.0, (0.1, 0.1, 0.1), position=tuple(where + (0.5, 0, 0)))
    pin = sr.Spherical("pin", sr.ground, body, point=tuple(where))
    spring = sr.TSDA(
        "s", sr.ground.point(*(where + (0.5, 0, 1.0))), body.point(0.1, 0, 0), k=90.0, length=0.6
    )
    system = sr.System(sr.Model("m", [body], [pin], [spring], gravity=(0, 0, -9.81)))
    found = sr.equilibrium(system)
    assert found.success, found.message
    assert found.stability == sr.equilibrium(system).stability
    assert sr.modes(system, found.q).success


def test_a_soft_spring_beside_a_stiff_one_is_felt() -> None:
    """A stiffness below 1e-9 of another body's is no lack of resistance, and its sign counts."""
    bodies, joints, forces = [], [], []
    for n, k in enumerate((1e12, 4.0)):
        body = sr.Body(f"b{n}", mass=1.0, inertia=(1, 1, 1), position=(0, n, 0))
        joints.append(sr.Translational(f"j{n}", sr.ground, body, point=(0, n, 0), axis=(1, 0, 0)))
        forces.append(sr.TSDA(f"s{n}", sr.ground.point(-2, n, 0), body.point(0, 0, 0), k=k, length=2.0))
        bodies.append(body)
    system = sr.System(sr.Model("two", bodies, joints, forces, gravity=(9.81, 0, 0)))
    found = sr.equilibrium(system)
    assert (found.success, found.stability) == (True, "stable"), found.message
    assert found.q[7] == pytest.approx(9.81 / 4)
    assert found.squares == pytest.approx([4.0, 1e12])
