"""Laws of tyres beside a second implementation, published numbers, and what every tyre law must fulfil."""

from __future__ import annotations

import itertools
from math import atan, tan
from typing import Any

import numpy as np
import pytest
from tests.tyres import second_laws
from tests.tyres.hmmwv_pac2002 import HMMWV

import sarrus as sr
from sarrus.elements.forces.tyres import (
    Brush,
    Fiala,
    MagicFormula52,
    MagicFormula61,
    Slip,
    TMeasy,
    TyreLaw,
    Wrench,
    sampled,
)
from sarrus.elements.forces.tyres.rounding import fading, limited, rounded_absolute

CAR = dict(sr.load_tyre("passenger_car").coefficients)
CAR_52 = {name: value for name, value in CAR.items() if name != "FITTYP"} | {
    "PHY3": 0.03,
    "PTX1": 1.9,
    "PTX2": 0.3,
    "PTX3": 0.1,
    "PTY1": 2.1,
    "PTY2": 1.8,
    "LFZO": 0.9,
}
WHEEL = {"radius": 0.32, "k": 2e5, "c": 0.0, "sigma_x": 0.2, "sigma_y": 0.4, "rolling_resistance": 0.0}
FIALA = WHEEL | {
    "c_kappa": 193929.0,
    "c_alpha": 50000.0,
    "mu_min": 0.5568,
    "mu_max": 0.9835,
    "width": 0.318,
}
BRUSH = WHEEL | {"c_kappa": 8e4, "c_alpha": 8e4, "mu": 1.0, "half_length": 0.07}
NAMES = {
    "dx": "slope_x",
    "fxm": "peak_force_x",
    "fxs": "sliding_force_x",
    "sxm": "peak_slip_x",
    "sxs": "sliding_slip_x",
}
NAMES |= {name.replace("x", "y"): long.replace("_x", "_y") for name, long in NAMES.items()}
NAMES |= {"n0": "trail", "s0": "zero_slip", "se": "end_slip"}
MICROBUS = WHEEL | {"mu": 1.0, "nominal_load": 1900.0}
MICROBUS |= {
    f"{long}_{n + 1}": second_laws.MICROBUS[short][n] for short, long in NAMES.items() for n in (0, 1)
}
LAWS: dict[str, TyreLaw] = {
    "fiala": Fiala(FIALA),
    "brush": Brush(BRUSH),
    "tmeasy": TMeasy(MICROBUS),
    "magic formula 5.2": MagicFormula52(CAR_52),
    "magic formula 6.1": MagicFormula61(CAR),
}
FIELDS = ("F_x", "F_y", "M_x", "M_y", "M_z")


def wrench(law: TyreLaw, load: Any, kappa: Any, alpha: float, gamma: Any, speed: float = 16.6) -> Wrench:
    return law.wrench(Slip(kappa, tan(alpha), gamma, load, speed))


@pytest.mark.parametrize("old", [False, True])
def test_magic_formulas_beside_a_second_implementation(old: bool) -> None:
    coefficients = CAR_52 if old else CAR
    grid = itertools.product(
        (1500.0, 4500.0, 8000.0), (-0.15, 0.0, 0.06), (-0.2, 0.0, 0.05), (-0.05, 0.0, 0.08), (1.0, 0.8)
    )
    for load, kappa, alpha, gamma, pressure in grid:
        given = coefficients | {"INFLPRES": pressure * coefficients["NOMPRES"]}
        found = wrench((MagicFormula52 if old else MagicFormula61)(given), load, kappa, alpha, gamma)
        wanted = second_laws.magic_formula(given, load, kappa, alpha, gamma, 16.6, old)
        for name in FIELDS:
            value = wanted[name.replace("_", "")]
            assert getattr(found, name) == pytest.approx(value, rel=1e-9, abs=1e-6), (
                name,
                load,
                kappa,
                alpha,
                gamma,
            )


PUBLISHED = [  # load, slip, slip angle, forces and moments, to the printed digits
    ((4000, 0.0, 0.05), (-23.5601106, -1229.51883, 0.0, -15.0368, 2.57751766)),
    ((4000, -0.05, -0.1), (-2267.89505, 2156.50264, 0.0, -15.0368, 11.2817989)),
]


@pytest.mark.parametrize(("state", "wanted"), PUBLISHED)
def test_the_tyre_of_the_hmmwv_of_chrono(state: tuple[float, ...], wanted: tuple[float, ...]) -> None:
    load, kappa, alpha = state
    found = wrench(MagicFormula52(HMMWV), load, kappa, alpha, 0.0, 16.7)
    assert tuple(found[:4]) == pytest.approx(wanted[:4], rel=2e-9, abs=1e-9)
    assert found.M_z == pytest.approx(wanted[4], rel=3e-7)  # its cos α has a rounding of 1e-6 m/s there


SIMPLE: list[tuple[str, tuple[float, ...], tuple[float, ...]]] = [  # law; κ, α, load; F_x, F_y, M_z
    ("fiala", (0.02, 0, 8000), (3878.58, 0, 0)),
    ("fiala", (0.1, 0, 8000), (6796.342962, 0, 0)),
    ("fiala", (0, 0.05, 8000), (0, -2240.763881, 188.011227)),
    ("fiala", (0, 0.3, 8000), (0, -6714.106210, 23.572454)),
    ("fiala", (0, 0.6, 8000), (0, -5532.630591, 0)),
    ("fiala", (0.05, 0.1, 5000), (4114.030360, -3437.185322, 141.077612)),
    ("brush", (0.02, 0, 4000), (1372.512723, 0, 0)),
    ("brush", (0, 0.05, 4000), (0, -2816.297161, 27.642772)),
    ("brush", (0.05, 0.05, 4000), (2354.664608, -2356.628793, 14.870443)),
    ("brush", (-0.05, 0.05, 4000), (-2466.201006, -2468.258231, 12.556679)),
    ("brush", (0, 0.2, 4000), (0, -4000, 0)),
]


@pytest.mark.parametrize(("name", "state", "wanted"), SIMPLE)
def test_simple_laws_at_computed_points(
    name: str, state: tuple[float, ...], wanted: tuple[float, ...]
) -> None:
    """Points of a second implementation; Fiala's tyre is that of the HMMWV of Chrono."""
    kappa, alpha, load = state
    found = wrench(LAWS[name], load, kappa, alpha, 0.0)
    assert (found.F_x, found.F_y, found.M_z) == pytest.approx(wanted, rel=1e-8, abs=2e-6)


@pytest.mark.parametrize("load", [900.0, 4000.0, 7000.0])
def test_simple_laws_beside_a_second_implementation(load: float) -> None:
    for kappa, alpha in itertools.product((-0.6, -0.05, 0.004, 0.3, 2.0), (-0.5, -0.04, 0.003, 0.2)):
        for name, wanted in (
            ("fiala", second_laws.fiala(kappa, alpha, load, 193929.0, 50000.0, 0.5568, 0.9835, 0.318)),
            ("brush", second_laws.brush(kappa, alpha, load, 1.0, 8e4, 8e4, 0.07)),
        ):
            found = wrench(LAWS[name], load, kappa, alpha, 0.0)
            assert (found.F_x, found.F_y, found.M_z) == pytest.approx(wanted, rel=1e-7, abs=2e-5), name


POINTS_OF_TMEASY = [  # s_x, s_y, load; F_x, F_y, n/L: the tyre of the microbus of Chrono
    ((0.05, 0, 1900), (1426.120229, 0, None)),
    ((0, 0.05, 1900), (0, 1226.022386, 0.126004)),
    ((0.2, 0, 3000), (3146.671682, 0, None)),
    ((0, 0.3, 3000), (0, 2728.592564, -0.068787)),
    ((0.08, -0.06, 2500), (2009.156546, -1506.867410, 0.122129)),
    ((1, 0.5, 2500), (1779.898304, 889.949152, -0.101266)),
]


@pytest.mark.parametrize(("state", "wanted"), POINTS_OF_TMEASY)
def test_tmeasy_at_computed_points(state: tuple[float, ...], wanted: tuple[Any, ...]) -> None:
    s_x, s_y, load = state
    law: Any = LAWS["tmeasy"]
    q = load / 1900
    F_x, F_y = q * law._secant(s_x, s_y, q, (1, 0)) * s_x, q * law._secant(s_x, s_y, q, (0, 1)) * s_y
    assert (F_x, F_y) == pytest.approx(wanted[:2], rel=1e-8, abs=1e-6)
    assert wanted[2] is None or law.trail(s_y, q) == pytest.approx(wanted[2], abs=6e-7)


def test_tmeasy_beside_a_second_implementation() -> None:
    law: Any = LAWS["tmeasy"]
    for s_x, s_y, load in itertools.product(
        (-0.9, -0.1, 0.0, 0.14, 0.4), (-1.2, 0.02, 0.3), (500.0, 1900.0, 4500.0)
    ):
        wanted = second_laws.tmeasy(s_x, s_y, load, second_laws.MICROBUS)
        secant = load / 1900 * law._secant(s_x, s_y, load / 1900, (1, 0))
        found = (secant * s_x, secant * s_y, law.trail(s_y, load / 1900))
        assert found == pytest.approx(wanted, rel=1e-7, abs=1e-6)


def symmetric(coefficients: dict[str, float]) -> dict[str, float]:
    """Without shifts and unequal sides."""
    zero = "PHX1 PHX2 PVX1 PVX2 RHX1 PEX4 RHY1 RHY2"
    sides = sr.TyreFile("", coefficients).mirrored().coefficients
    one_sided = [name for name, value in coefficients.items() if sides[name] != value]
    return coefficients | dict.fromkeys((*zero.split(), *one_sided), 0.0)


SYMMETRIC = LAWS | {
    "magic formula 5.2": MagicFormula52(symmetric(CAR_52)),
    "magic formula 6.1": MagicFormula61(symmetric(CAR)),
}


@pytest.mark.parametrize("name", LAWS)
def test_slopes_at_zero_are_the_slip_stiffnesses(name: str) -> None:
    law: Any = SYMMETRIC[name]
    step, load = 1e-7, 3000.0
    F_x = (wrench(law, load, step, 0, 0).F_x - wrench(law, load, -step, 0, 0).F_x) / (2 * step)
    F_y = (wrench(law, load, 0, step, 0).F_y - wrench(law, load, 0, -step, 0).F_y) / (2 * step)
    at = Slip(0, 0, 0, load)
    if "magic" in name:
        K_x, K_y = law.longitudinal_stiffness(at), law.cornering_stiffness(load, 0)
    elif name == "tmeasy":
        q = load / 1900
        K_x, K_y = (q * law._parabola(f"slope_{axis}", q) for axis in "xy")
        K_y = -K_y
    else:
        K_x, K_y = law.c_kappa, -law.c_alpha
    assert (F_x, F_y) == pytest.approx((K_x, K_y), rel=2e-4)


@pytest.mark.parametrize("name", LAWS)
def test_left_is_right_without_shifts(name: str) -> None:
    law = SYMMETRIC[name]
    for kappa, alpha, gamma in itertools.product((-0.1, 0.0, 0.2), (0.02, 0.3), (0.0, 0.06)):
        one, other = wrench(law, 4000.0, kappa, alpha, gamma), wrench(law, 4000.0, kappa, -alpha, -gamma)
        signs = np.array([1, -1, -1, 1, -1])
        assert np.array(one) == pytest.approx(signs * np.array(other), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("kind", [MagicFormula52, MagicFormula61])
def test_the_mirrored_tyre_is_the_tyre_in_a_mirror(kind: Any) -> None:
    given = CAR_52 if kind is MagicFormula52 else CAR
    law, mirror = kind(given), kind(sr.TyreFile("", given).mirrored().coefficients)
    for kappa, alpha, gamma in itertools.product((-0.1, 0.0, 0.2), (-0.2, 0.03), (-0.05, 0.06)):
        one, other = wrench(law, 5000.0, kappa, alpha, gamma), wrench(mirror, 5000.0, kappa, -alpha, -gamma)
        assert np.array(one) == pytest.approx(
            np.array([1, -1, -1, 1, -1]) * np.array(other), rel=1e-7, abs=1e-9
        )


@pytest.mark.parametrize("name", LAWS)
def test_slip_takes_energy(name: str) -> None:
    """F·v_s ≤ 0, with the sliding velocity κ V_x against the direction, and tan α V_x to the left."""
    for kappa, alpha in itertools.product((-0.9, -0.1, -0.01, 0.01, 0.3, 1.0), (-0.8, -0.05, 0.01, 0.3)):
        found = wrench(SYMMETRIC[name], 3500.0, kappa, alpha, 0.0)
        assert -found.F_x * kappa + found.F_y * tan(alpha) < 0


@pytest.mark.parametrize("name", LAWS)
def test_reverse_is_the_tyre_turned_around(name: str) -> None:
    """Turned by 180° about the vertical axis, F_x and F_y have the opposite sign; M_z has the same."""
    law = SYMMETRIC[name]
    for kappa, alpha in itertools.product((-0.3, 0.0, 0.2), (-0.3, 0.04)):
        ahead = law.wrench(Slip(kappa, tan(alpha), 0.0, 3500.0, 16.6, 1))  # V_x, V_sx, V_sy
        back = law.wrench(Slip(-kappa, -tan(alpha), 0.0, 3500.0, -16.6, -1))  # all with the opposite sign
        found, wanted = (back.F_x, back.F_y, back.M_z), (-ahead.F_x, -ahead.F_y, ahead.M_z)
        assert found == pytest.approx(wanted, rel=2e-6, abs=1e-3)


@pytest.mark.parametrize("load", [700.0, 1900.0, 5000.0])
def test_bounds_at_standstill_are_slips_with_full_sliding(load: float) -> None:
    tmeasy: Any = LAWS["tmeasy"]
    q = load / 1900
    for name, wanted in (
        ("brush", (load, load)),
        ("tmeasy", [q * tmeasy.number(f"sliding_force_{axis}", q) for axis in "xy"]),
    ):
        x, y = LAWS[name].sliding_slips(load)
        along = LAWS[name].wrench(Slip(x, 0.0, 0.0, load, 0.0, 0))
        across = LAWS[name].wrench(Slip(0.0, y, 0.0, load, 0.0, 0))
        assert (along.F_x, -across.F_y) == pytest.approx(wanted, rel=1e-5)
    fiala: Any = LAWS["fiala"]
    x, y = fiala.sliding_slips(load)
    across = Slip(0.0, y, 0.0, load, 0.0, 0)
    assert fiala.wrench(across).F_y == pytest.approx(-fiala.friction(across))


def test_a_length_is_that_of_its_own_direction() -> None:
    """One stiffness of the carcass alone serves its direction; the other one has the empirical length, if any."""
    at = Slip(0.0, 0.0, 0.0, 4000.0)
    both: Any = LAWS["magic formula 6.1"]
    longitudinal, lateral = both.relaxation_lengths(at)
    for missing, wanted in (("LATERAL", (longitudinal, 0)), ("LONGITUDINAL", (0, lateral))):
        given = {name: value for name, value in CAR.items() if name != f"{missing}_STIFFNESS"}
        assert MagicFormula61(given).relaxation_lengths(at) == pytest.approx(wanted)


@pytest.mark.parametrize(("name", "mu"), [("brush", 1.0), ("tmeasy", 1.2)])
def test_forces_are_within_friction(name: str, mu: float) -> None:
    for kappa, alpha in itertools.product((-0.9, -0.1, 0.01, 0.3), (-0.8, -0.05, 0.01, 0.3)):
        found = wrench(LAWS[name], 3000.0, kappa, alpha, 0.0)
        assert np.hypot(found.F_x, found.F_y) <= mu * 3000.0 * (1 + 1e-9)


def test_pure_slip_of_the_magic_formula_has_factors_of_one() -> None:
    law: Any = LAWS["magic formula 6.1"]
    assert law.combined_x(Slip(0.1, 0.0, 0.0, 4000.0)) == pytest.approx(1)
    assert law.combined_y(Slip(0.0, 0.1, 0.0, 4000.0)) == pytest.approx(1)


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("field", ["kappa", "tan_alpha", "gamma", "load", "speed"])
def test_complex_steps_are_the_slopes(name: str, field: str) -> None:
    """A law is a formula without branches on values: a complex step is its derivative, beside central differences."""
    law, at = LAWS[name], Slip(0.043, 0.071, 0.03, 3700.0, 15.0)
    value = getattr(at, field)
    step = 1e-30

    def along(change: complex) -> Any:
        return np.array(law.wrench(at._replace(**{field: value + change})))

    found = along(1j * step).imag / step
    h = 1e-5 * max(abs(value), 0.1)
    wanted = (along(h) - along(-h)).real / (2 * h)
    assert found == pytest.approx(wanted, rel=2e-6, abs=1e-5 * max(1.0, np.abs(wanted).max()) + 1e-6)


@pytest.mark.parametrize("name", LAWS)
def test_derivatives_by_all_coefficients_are_complex_steps(name: str) -> None:
    law, names = LAWS[name], tuple(LAWS[name].given)
    kappa, tan_alpha = np.array([0.04, -0.1, 0.3, 0.0]), np.array([0.07, -0.02, 0.5, 0.1])
    values, slopes = sampled(law, Slip(kappa, tan_alpha, 0.03, 3700.0, 15.0), names)
    for place, (k, a) in enumerate(zip(kappa, tan_alpha, strict=True)):
        slip = Slip(float(k), float(a), 0.03, 3700.0, 15.0)
        assert values[:, place] == pytest.approx(np.array(law.wrench(law.in_range(slip))), rel=1e-12)
        for column, coefficient in enumerate(names):
            moved = type(law)(law.given | {coefficient: law.given[coefficient] + 1e-30j})
            wanted = np.array(moved.wrench(moved.in_range(slip))).imag / 1e-30
            found = slopes[:, place, column]
            assert found == pytest.approx(wanted, rel=1e-9, abs=1e-12 * (1 + abs(wanted).max())), coefficient


@pytest.mark.parametrize("name", LAWS)
def test_a_tyre_in_the_air_has_no_force(name: str) -> None:
    found = wrench(LAWS[name], 0.0, 0.3, 0.2, 0.05)
    assert np.array(found) == pytest.approx(np.zeros(5), abs=1e-5)
    assert np.isfinite(np.array(LAWS[name].wrench(Slip(0.3, 0.2, 0.05, 1e-30j)))).all()


@pytest.mark.parametrize("name", LAWS)
def test_states_out_of_range_have_finite_forces(name: str) -> None:
    law = LAWS[name]
    for kappa, tan_alpha, gamma, load in itertools.product((-1e6, 1e6), (-1e9, 1e9), (-1.2, 1.2), (0.0, 1e7)):
        found = law.wrench(law.in_range(Slip(kappa, tan_alpha, gamma, load, 0.0, 0.0)))
        assert np.isfinite(np.array(found)).all()
    limit = LAWS["magic formula 6.1"].in_range(Slip(9.0, 1e9, 0.9, 1e9))
    assert limit.kappa == pytest.approx(1.65)
    assert 1.5 < atan(limit.tan_alpha) < 1.57
    assert limit.load == pytest.approx(11000 + 1550 / 2)


def test_rounded_functions() -> None:
    x = np.linspace(-3, 3, 13)
    assert [rounded_absolute(v, 0.02) for v in x] == pytest.approx(abs(x), abs=1e-15)
    assert (fading(0.0, 1.0), fading(1.0, 1.0), fading(-7.0, 1.0)) == (1, 0, 0)
    assert [limited(v, -2, 2) for v in x] == pytest.approx(np.clip(x, -2.2, 2.2), abs=0.06)
    h = 1e-5
    for place in (0.0, 0.4):  # second differences on both sides agree
        left, right = (
            (fading(place + s * 2 * h, 0.4) - 2 * fading(place + s * h, 0.4) + fading(place, 0.4)) / h**2
            for s in (-1, 1)
        )
        assert left == pytest.approx(right, abs=0.1)


def test_the_load_is_the_derivative_of_the_energy() -> None:
    for law in LAWS.values():
        for depth in (-0.002, -0.0003, 0.0002, 0.004, 0.03):
            step = 1e-20
            slope = law.stored_energy(depth + 1j * step, 1e-3).imag / step
            assert slope == pytest.approx(law.vertical_force(depth, 0.0, 0.0, 1e-3), rel=1e-9, abs=1e-9)


def test_the_static_load_of_a_tyre_file() -> None:
    """F_z0 [Q_FZ1 ρ/R + Q_FZ2 (ρ/R)²], with the given stiffness where the load is the nominal one."""
    law: Any = LAWS["magic formula 6.1"]
    R, F_0, k, second = 0.317, 4500.0, 210000.0, 14.5
    first = np.sqrt((k * R / F_0) ** 2 - 4 * second)
    rho = 0.02 / R
    assert law.vertical_force(0.02, 0, 0, 1e-3) == pytest.approx(F_0 * (first * rho + second * rho**2))
    rho = (k * R / F_0 - first) / (2 * second)  # where F_z = F_0
    assert F_0 * (first * rho + second * rho**2) == pytest.approx(F_0)
    assert F_0 * (first + 2 * second * rho) / R == pytest.approx(k)
