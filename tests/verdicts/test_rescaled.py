"""`assemble` and `simulate` in any units: open joints, contradictions, singular configurations; sizes of terms."""

import numpy as np
import pytest
from tests.verdicts.random_mechanisms import KINDS, mechanism

import sarrus as sr

UNITS = [(1e-6, 1e-9), (1e4, 1e6), (1e-6, 1e6), (1e4, 1e-9)]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*assembly changed")
@pytest.mark.parametrize("kind", KINDS)
def test_rough_positions_are_assembled(kind: str) -> None:
    """Disturbed by a tenth of its size, and with any velocities."""
    for seed in range(50):
        for length, mass in ((1.0, 1.0), UNITS[seed % 4]):
            system = mechanism(seed, kind, length=length, mass=mass).system()
            unit, random = (
                np.tile(np.repeat([length, 1.0], (3, 4)), len(system.bodies)),
                np.random.default_rng(seed),
            )
            q, v = (unit * random.normal(size=(2, system.nq)) * [[0.1], [1.0]]) + [system.q0, 0 * system.q0]
            found = sr.assemble(system, q, v)
            assert found.success, (seed, length, found.message)
            J = system.Phi_q(found.q).toarray() * unit
            assert abs(J @ (found.v / unit)).max() < 1e-8 * abs(J).max()


@pytest.mark.filterwarnings("ignore:.*assembly changed")
@pytest.mark.parametrize(("length", "mass"), [(1.0, 1.0), *UNITS])
def test_contradictions_are_found(length: float, mass: float) -> None:
    """A link longer by a thousandth than a rod about a ball joint can reach, and a rate across the joint."""

    def rod(long: float) -> sr.System:
        body = sr.Body("rod", mass=mass, inertia=(mass * length**2,) * 3)
        pins = [
            sr.Spherical("first", sr.ground, body, point=(0, 0, 0)),
            sr.Distance(
                "second",
                sr.ground.point(2 * length, 0, 0),
                body.point(length, 0, 0),
                length=(2 + long) * length,
            ),
        ]
        return sr.System(sr.Model("rod", [body], pins))

    assert sr.assemble(rod(0.9)).success
    found = sr.assemble(rod(1.001))
    assert not found.success
    assert "could not be assembled" in found.message
    assert not sr.assemble(rod(0.9), rates={"rod.x": length}).success


@pytest.mark.slow
@pytest.mark.parametrize(("length", "mass"), [(1.0, 1.0), *UNITS])
def test_a_lockup_is_the_same(length: float, mass: float) -> None:
    """A driven crank whose coupler is too short locks at the same time in any units."""
    z = (0, 0, 1)

    def at(x: float, y: float) -> tuple[float, float, float]:
        return (x * length, y * length, 0)

    def rod(name: str, p: np.ndarray, q: np.ndarray) -> sr.Body:
        turn = sr.AxisAngle(z, float(np.arctan2(*(q - p)[::-1])))
        return sr.Body(name, mass, (mass * length**2,) * 3, position=at(*(0.5 * (p + q))), orientation=turn)

    O, C, B = np.zeros(2), np.array([0.0, 1.0]), np.array([2.0, 0.0])
    d = np.hypot(*(B - C))
    a = (1.5**2 - 1.2**2 + d * d) / (2 * d)
    along = (B - C) / d
    D = C + a * along + np.sqrt(1.5**2 - a * a) * np.array([-along[1], along[0]])
    crank, coupler, rocker = rod("crank", O, C), rod("coupler", C, D), rod("rocker", B, D)
    joints = [
        sr.Revolute("A", sr.ground, crank, point=at(*O), axis=z),
        sr.Revolute("C", crank, coupler, point=at(*C), axis=z),
        sr.Revolute("D", coupler, rocker, point=at(*D), axis=z),
        sr.Revolute("B", sr.ground, rocker, point=at(*B), axis=z),
    ]
    motor = sr.AngleDriver("motor", "A", lambda t: t)
    system = sr.System(sr.Model("four-bar", [crank, coupler, rocker], joints, drivers=[motor]))
    run = sr.kinematics(system, np.linspace(0, 3, 31))
    reach = np.arccos((1 + 4 - 2.7**2) / 4)  # crank angle at which coupler and rocker are in line
    assert run.status == "lock-up", run.message
    assert f"t = {reach - np.pi / 2:.6g}"[:9] in run.message
    assert "singular" in sr.simulate(system, until=3.0, method=sr.ODE()).status


def test_terms_are_those_of_single_elements() -> None:
    """Two springs pull against each other: the sum of absolute forces does not vanish as their sum does."""
    body = sr.Body("b", mass=2.0, inertia=(1, 1, 1))
    springs = [
        sr.TSDA(f"s{int(x + 3)}", sr.ground.point(x, 0, 0), body.point(0, 0, 0), k=10.0, length=1.0)
        for x in (-3.0, 3.0)
    ]
    system = sr.System(sr.Model("held", [body], [], springs, gravity=(0, 0, -9.81)))
    rest = np.zeros(7)
    assert system.Q(system.q0, rest)[:3] == pytest.approx([0, 0, -19.62])
    assert system.magnitude("Q", q=system.q0, v=rest, t=0.0)[:3] == pytest.approx([40, 0, 19.62])
    stiffness = system.magnitude("Q_q", q=system.q0, v=rest, t=0.0).toarray()[:3, :3]
    assert stiffness == pytest.approx(np.diag([20.0, 40 / 3, 40 / 3]))
