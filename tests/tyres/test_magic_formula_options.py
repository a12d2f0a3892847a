"""Options of the Magic Formula: large angles, turn slip, the ellipse of combined slip, and the load of 6.2."""

from __future__ import annotations

import itertools
from math import sin, sqrt, tan
from typing import Any

import numpy as np
import pytest
from tests.tyres import second_laws
from tests.tyres.mfeval_61 import LARGE_ANGLES, MFEVAL, PRESSURES, PUBLISHED
from tests.tyres.test_laws import CAR, CAR_52, FIELDS, wrench

import sarrus as sr
from sarrus.elements.forces.tyres import (
    LargeAngles52,
    LargeAngles61,
    LargeAnglesTurnSlip,
    MagicFormula52,
    MagicFormula61,
    Slip,
    TurnSlip,
)

V = 16.6
SPINS = {
    "PDXP1": 0.4, "PDXP2": 0.1, "PDXP3": 0.3, "PKYP1": 1.0, "PDYP1": 0.4, "PDYP2": 0.2, "PDYP3": 0.5, "PDYP4": 0.3,
    "PHYP1": 1.0, "PHYP2": 0.15, "PHYP3": 0.02, "PHYP4": -4.0, "PECP1": 0.5, "PECP2": -0.1, "QDTP1": 10.0, "QCRP1": 0.2,
    "QCRP2": 0.1, "QBRP1": 0.1, "QDRP1": 0.9, "QDRP2": -1.5,
}  # fmt: skip


@pytest.mark.parametrize(("state", "wanted"), PUBLISHED)
def test_forces_of_a_published_file(state: tuple[float, ...], wanted: tuple[float, ...]) -> None:
    found = wrench(MagicFormula61(MFEVAL), *state)
    assert tuple(found) == pytest.approx(wanted, rel=2e-6, abs=2e-7)


def test_pressures_and_large_angles_of_a_published_file() -> None:
    state = 4000.0, -0.03, 0.05, 0.02
    for pressure, wanted in PRESSURES.items():
        found = wrench(MagicFormula61(MFEVAL | {"INFLPRES": pressure}), *state)
        assert tuple(found[:4]) == pytest.approx(wanted[:4], rel=2e-8)
        assert found.M_z == pytest.approx(wanted[4], rel=2e-7)  # its cos α has a rounding of 1e-6 m/s there
    found = wrench(LargeAngles61(MFEVAL), *state)
    assert tuple(found[:4]) == pytest.approx(LARGE_ANGLES[:4], rel=2e-8)
    assert found.M_z == pytest.approx(LARGE_ANGLES[4], rel=2e-7)


@pytest.mark.parametrize("old", [False, True])
def test_large_angles_beside_a_second_implementation(old: bool) -> None:
    given = CAR_52 if old else CAR
    law = (LargeAngles52 if old else LargeAngles61)(given)
    for load, kappa, alpha, gamma in itertools.product(
        (1500.0, 6000.0), (-0.15, 0.06), (-0.5, 0.02, 0.2), (-0.2, 0.0, 0.1)
    ):
        wanted = second_laws.magic_formula(given, load, kappa, alpha, gamma, V, old, star=True)
        found = wrench(law, load, kappa, alpha, gamma)
        for name in FIELDS:
            assert getattr(found, name) == pytest.approx(wanted[name.replace("_", "")], rel=1e-9, abs=1e-6)


def turned(law: Any, load: float, kappa: float, alpha: float, gamma: float, yaw: float, spin: float) -> Any:
    return law.wrench(Slip(kappa, tan(alpha), gamma, load, V, 1, yaw / V, spin / V))


@pytest.mark.parametrize("star", [False, True])
@pytest.mark.parametrize("kind", ["car", "mfeval"])
def test_turn_slip_beside_a_second_implementation(kind: str, star: bool) -> None:
    given = CAR | SPINS if kind == "car" else MFEVAL
    law = (LargeAnglesTurnSlip if star else TurnSlip)(given)
    for load, kappa, alpha, gamma, yaw in itertools.product(
        (1500.0, 6000.0), (-0.1, 0.05), (-0.2, 0.04), (-0.05, 0.08), (-30.0, -2.0, 0.3, 8.0, 200.0)
    ):
        wanted = second_laws.magic_formula(
            given, load, kappa, alpha, gamma, V, False, star=star, turn=(yaw, 50.0)
        )
        found = turned(law, load, kappa, alpha, gamma, yaw, 50.0)
        for name in FIELDS:
            value = wanted[name.replace("_", "")]
            margin = 1e-3 if name == "M_z" else 1e-5  # ζ_7 is rounded near φ = 0
            assert getattr(found, name) == pytest.approx(value, rel=1e-7, abs=margin), (name, yaw)


def test_without_turn_slip_all_factors_are_one() -> None:
    law, plain = TurnSlip(CAR | SPINS), MagicFormula61(CAR)
    for load, kappa, alpha in itertools.product((1500.0, 6000.0), (-0.1, 0.0, 0.05), (-0.2, 0.0, 0.04)):
        found = turned(law, load, kappa, alpha, 0.0, 0.0, 55.0)
        assert tuple(found) == pytest.approx(
            tuple(wrench(plain, load, kappa, alpha, 0.0)), rel=1e-9, abs=1e-6
        )
    factors = law.factors(Slip(0.1, 0.1, 0.0, 4000.0))
    assert tuple(factors) == (0, 1, 1, 1, 1, 1)


def test_turn_slip_of_the_inclination_is_the_camber_stiffness() -> None:
    """A wheel that rolls freely at a small inclination has the same F_y with and without turn slip."""
    given = (
        CAR | SPINS | dict.fromkeys(("PVY3", "PVY4", "QDZ10", "QDZ11", "PPZ2", "QHZ3", "QHZ4", "PKY3"), 0.0)
    )
    given |= {"LMUY": 1.0, "PPY5": 0.0}
    law, plain, R = TurnSlip(given), MagicFormula61(given), given["UNLOADED_RADIUS"]

    def slope(of: Any) -> np.ndarray:
        h, values = 1e-3, []
        for gamma in (h, -h):
            spin = V / R * gamma / sin(gamma)
            values.append(np.array(of.wrench(Slip(0.0, 0.0, gamma, 4500.0, V, 1, 0.0, spin / V))))
        return (values[0] - values[1]) / (2 * h)

    found, wanted = slope(law), slope(plain)
    assert found[1] == pytest.approx(wanted[1], rel=2e-3)
    assert wanted[1] < -1000


def test_the_moment_of_parking() -> None:
    """A wheel that is turned at standstill has the moment M_z∞ = QCRP1 μ_y R_0 F_z √(F_z/F_z0) against the yaw rate."""
    given = CAR | SPINS | {"QDRP1": 1.0, "QDRP2": 0.0}
    law: Any = TurnSlip(given)
    for load in (2000.0, 4500.0, 7000.0):
        mu = law.lateral(Slip(0, 0, 0, load), 0.0).mu
        most = 0.2 * mu * given["UNLOADED_RADIUS"] * load * sqrt(load / given["FNOMIN"])
        left, right = (law.wrench(Slip(0.0, 0.0, 0.0, load, 0.0, 0.0, phi, 0.0)) for phi in (1e9, -1e9))
        assert (left.M_z, right.M_z) == pytest.approx((-most, most), rel=1e-6)


def test_the_ellipse_beside_the_formulas_of_adams() -> None:
    shifts = dict.fromkeys(("PVX1", "PVX2", "PVY1", "PVY2", "PVY3", "PVY4"), 0.0)
    given = {name: value for name, value in (CAR_52 | shifts).items() if not name.startswith(("RC", "RV"))}
    law: Any = MagicFormula52(given)
    for load, kappa, alpha, gamma in itertools.product(
        (1500.0, 6000.0), (-0.9, -0.05, 0.02, 0.3), (-0.4, -0.03, 0.1), (0.0, 0.05)
    ):
        found = wrench(law, load, kappa, alpha, gamma)
        wanted = second_laws.ellipse(given, load, kappa, alpha, gamma, V)
        assert (found.F_x, found.F_y) == pytest.approx(wanted, rel=1e-7, abs=1e-4)
        at = Slip(kappa, tan(alpha), gamma, load)
        x, y = law.longitudinal(at).mu * load, law.lateral(at, gamma).mu * load
        assert (found.F_x / x) ** 2 + (found.F_y / y) ** 2 < 1 + 1e-6
    assert np.isfinite(np.array(law.wrench(Slip(0.0, 0.0, 0.0, 1e-30j)))).all()


def test_pure_slip_on_the_ellipse_is_pure_slip() -> None:
    zero = dict.fromkeys(("PHX1", "PHX2", "PVX1", "PVX2", "PHY1", "PHY2", "PVY1", "PVY2"), 0.0)
    given = {name: value for name, value in (CAR | zero).items() if not name.startswith(("RC", "RV"))}
    law: Any = MagicFormula61(given)
    for slip in (-0.3, 1e-4, 0.1):
        along, across = wrench(law, 4000.0, slip, 0.0, 0.0), wrench(law, 4000.0, 0.0, slip, 0.0)
        assert along.F_x == pytest.approx(law.longitudinal(Slip(slip, 0, 0, 4000.0)).force, rel=1e-12)
        assert across.F_y == pytest.approx(law.lateral(Slip(0, tan(slip), 0, 4000.0), 0.0).force, rel=1e-12)


CAMBER = {"FITTYP": 62.0, "Q_CAM1": 0.1, "Q_CAM2": 0.35, "Q_CAM3": 0.4, "WIDTH": 0.205, "ASPECT_RATIO": 0.55}


def test_the_compression_of_an_inclined_tread() -> None:
    law, plain = MagicFormula61(CAR | CAMBER), MagicFormula61(CAR)
    free = CAR["UNLOADED_RADIUS"] * CAR["Q_RE0"]
    for gamma, loaded in itertools.product((-0.15, 0.02, 0.1), (0.28, 0.31)):
        first, second = (0.1 * R + 0.35 * R * R for R in (loaded, free))
        edge = (first / second) ** 2 * (1.075 - 0.5 * 0.55) * 0.205 / 8 * abs(tan(gamma))
        rho = max(free - loaded + edge - 0.4 * (free - loaded) * abs(gamma), 0.0)
        assert law.depth(loaded, 0.0, gamma) == pytest.approx(rho, rel=1e-12)
        R, k, Q = CAR["UNLOADED_RADIUS"], CAR["VERTICAL_STIFFNESS"] / CAR["FNOMIN"], CAR["Q_FZ2"]
        load = CAR["FNOMIN"] * (sqrt((k * R) ** 2 - 4 * Q) * rho / R + Q * (rho / R) ** 2)
        assert law.vertical_force(law.depth(loaded, 0.0, gamma), 0, 0, 1e-3) == pytest.approx(load, rel=1e-12)
    assert law.depth(0.3, 0.0, 0.0) == plain.depth(0.3, 0.0, 0.0) == pytest.approx(free - 0.3)
    for gamma in (0.1, 1.4):
        assert law.depth(3 * free, 0.0, gamma) < -1.9 * free  # no contact high above the road


def test_a_wheel_that_leans_stands_on_its_edge() -> None:
    """The load of a 6.2 tyre at a height is that of the formula; a start that rolls knows it."""
    lean, height = 0.1, 0.3
    body = sr.Body("wheel", mass=20.0, inertia=(1, 1, 1), position=(0, 0, height))
    tyre = sr.MagicFormulaTyre(
        "tyre", body.point(0, 0, 0), axis=(0, np.cos(lean), np.sin(lean)), coefficients=CAR | CAMBER
    )
    run = sr.simulate(sr.System(sr.Model("lean", [body], [], [tyre])), until=1e-6, t_eval=[0.0])
    law, loaded = tyre.law(), height / np.cos(lean)
    depth = law.depth(loaded, 0.0, lean)
    assert run["tyre.inclination"][0] == pytest.approx(lean)
    assert run["tyre.compression"][0] == pytest.approx(depth)
    assert run["tyre.load"][0] == pytest.approx(law.vertical_force(depth, 0, 0, 1e-3))
    assert depth - MagicFormula61(CAR).depth(loaded, 0.0, lean) > 1e-3


def parked(yaw: float) -> sr.Trajectory:
    """A wheel on the road that is turned about the vertical axis at a constant rate."""
    body = sr.Body(
        "wheel", mass=400.0, inertia=(20, 20, 20), position=(0, 0, 0.2976), angular_velocity=(0, 0, yaw)
    )
    turn = sr.Revolute("turn", sr.ground, body, point=(0, 0, 0.2976), axis=(0, 0, 1))
    tyre = sr.MagicFormulaTyre("tyre", body.point(0, 0, 0), coefficients=CAR | SPINS, turn_slip=True)
    driver = sr.AngleDriver("steer", "turn", f"{yaw}*t")
    model = sr.Model("parking", [body], [turn], [tyre], drivers=[driver], gravity=(0, 0, -9.81))
    return sr.simulate(sr.System(model), until=1.0, t_eval=[0.0, 1.0])


def test_a_wheel_that_is_turned_as_it_stands() -> None:
    left, right = parked(0.5), parked(-0.5)
    law: Any = TurnSlip(CAR | SPINS)
    slip = Slip(0.0, 0.0, 0.0, left["tyre.load"][-1], 0.0, 0.0, 0.5 / 0.1, 0.0)  # |V| is at least creep
    assert left["tyre.aligning_moment"][-1] == pytest.approx(law.wrench(slip).M_z, rel=1e-3)
    assert left["tyre.aligning_moment"][-1] < -100 < 100 < right["tyre.aligning_moment"][-1]


@pytest.mark.slow
def test_derivatives_with_turn_slip() -> None:
    body = sr.Body(
        "wheel", mass=400.0, inertia=(60, 90, 60), position=(0, 0, 0.295), velocity=(3.0, 0.3, 0.0),
        angular_velocity=(0.05, 9.0, 0.9),
    )  # fmt: skip
    tyre = sr.MagicFormulaTyre(
        "tyre", body.point(0, 0, 0), axis=(0.02, 1, 0.03), coefficients=CAR | SPINS | CAMBER, turn_slip=True
    )
    report = sr.System(sr.Model("wheel", [body], [], [tyre], gravity=(0, 0, -9.81))).check_derivatives()
    assert report, report


WRONG: list[tuple[dict[str, float], dict[str, bool], str]] = [
    ({"FITTYP": 52.0}, {"turn_slip": True}, "turn_slip needs a FITTYP from 60 to 62, but it is 52"),
    ({"PHYP2": 0.0}, {"turn_slip": True}, r"PHYP2 must not be 0 for turn_slip, but is 0\. Correct it"),
    ({"QDRP1": 2.0}, {"turn_slip": True}, "QDRP1 must be between 0 and 2 for turn_slip, but is 2"),
    ({"QCRP1": -0.2}, {"turn_slip": True}, "QCRP1 must be greater than 0 for turn_slip, but is -0.2"),
    ({"PECP1": 1.0}, {"turn_slip": True}, "PECP1 must be less than 1 for turn_slip, but is 1"),
    ({"RCY1": 0.0}, {}, "coefficients has RCX1, but no RCY1, for forces in combined slip"),
    (CAMBER | {"WIDTH": 0.0}, {}, r"WIDTH must be greater than 0, which Q_CAM1 and Q_CAM2 need\. Correct it"),
    (CAMBER | {"ASPECT_RATIO": 55.0}, {}, "ASPECT_RATIO must be between 0 and 2, which"),
]


@pytest.mark.parametrize(("given", "options", "message"), WRONG)
def test_wrong_options_are_refused(given: dict[str, float], options: dict[str, bool], message: str) -> None:
    body = sr.Body("wheel", mass=20.0, inertia=(1, 1, 1))
    tyre = sr.MagicFormulaTyre("tyre", body.point(0, 0, 0), coefficients=CAR | SPINS | given, **options)
    with pytest.raises(sr.ModelError, match=message):
        tyre.tyre_law()


def test_turn_slip_without_its_coefficients_is_refused() -> None:
    body = sr.Body("wheel", mass=20.0, inertia=(1, 1, 1))
    tyre = sr.MagicFormulaTyre("tyre", body.point(0, 0, 0), coefficients=CAR, turn_slip=True)
    with pytest.raises(sr.ModelError, match="coefficients has no PHYP1, which turn_slip needs"):
        tyre.tyre_law()


def test_options_are_part_of_model_files(tmp_path: Any) -> None:
    body = sr.Body("wheel", mass=20.0, inertia=(1, 1, 1), position=(0, 0, 0.3))
    tyre = sr.MagicFormulaTyre(
        "tyre", body.point(0, 0, 0), coefficients=CAR | SPINS, turn_slip=True, large_angles=True
    )
    sr.Model("wheel", [body], [], [tyre]).save(tmp_path / "wheel.yaml")
    again: Any = sr.load(tmp_path / "wheel.yaml").forces[0]
    assert (again.turn_slip, again.large_angles) == (True, True)
    assert again.coefficients == tyre.coefficients
    text = (tmp_path / "wheel.yaml").read_text().replace("turn_slip: true", "turn_slip: often")
    (tmp_path / "wrong.yaml").write_text(text)
    with pytest.raises(sr.ModelError, match="turn_slip"):
        sr.load(tmp_path / "wrong.yaml")
