"""What is known of the examples in closed form: accelerations and energies at the start, limits, equilibria."""

from __future__ import annotations

import runpy

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq, fsolve
from scipy.special import ellipj, ellipk
from tests.examples.problems import FOLDER, columns_of, exactly, instant, system

import sarrus as sr
from sarrus.algebra import Array

G = 9.81
EXACT = 1e-9  # relative: of accelerations and forces in closed form
DIGITS = 2e-9  # of motions simulated with a tolerance of 1e-10
FLAT = 1e-12  # of the largest entry: what vanishes


def kinetic(name: str) -> float:
    return system(name).kinetic_energy(system(name).q0, system(name).v0)


def test_the_pendulum_swings_as_elliptic_functions_say() -> None:
    """sin(φ/2) = k sn(K - ωt), φ from the lowest point, released at 90°."""
    run, k = exactly("simple_pendulum", 2.4, np.linspace(0, 2.4, 7)), np.sqrt(0.5)
    sn, *_ = ellipj(ellipk(0.5) - np.sqrt(G) * run.t, 0.5)
    angle = 2 * np.arcsin(k * sn)
    assert run["ball"].position == pytest.approx(
        np.stack([np.sin(angle), -np.cos(angle), 0 * angle], axis=1), abs=DIGITS
    )


def test_the_pendulum_rests_below() -> None:
    rest = sr.equilibrium(system("simple_pendulum"))
    assert rest.q[:3] == pytest.approx([0, -1, 0], abs=EXACT)
    assert max(rest.squares) == pytest.approx(G)  # ω² = g / l


def four_bar_constant(n: int) -> float:
    """c in θ̈ = c sin θ, θ from upright: moments of weight over moments of inertia of uprights and couplers."""
    return G * ((n + 1) / 2 + n) / ((n + 1) / 3 + n)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("n", [1, 2, 4])
def test_four_bars_turn_over(n: int) -> None:
    """The time to an angle is the integral of dθ/θ̇, θ̇² = 1 + 2c (1 - cos θ)."""
    made = sr.System(runpy.run_path(str(FOLDER / "four_bars.py"))["four_bars"](n))
    run = sr.simulate(made, until=0.5, method=sr.ODE("DOP853", rtol=1e-10, atol=1e-12))
    x, y, _ = 2 * run["upright_0"].position[-1]
    c = four_bar_constant(n)
    time, _ = quad(lambda theta: 1 / np.sqrt(1 + 2 * c * (1 - np.cos(theta))), 0, np.arctan2(x, y))
    assert time == pytest.approx(0.5, rel=DIGITS)
    assert made.kinetic_energy(made.q0, made.v0) == pytest.approx(((n + 1) / 3 + n) / 2)


def test_four_bars_hang_and_swing() -> None:
    rest = sr.equilibrium(system("four_bars"))
    assert rest.stability == "stable"
    assert rest.q[:2] == pytest.approx([0, -0.5], abs=EXACT)
    assert rest.squares == pytest.approx([four_bar_constant(2)], rel=EXACT)


def flat_or_not(angle: float) -> Array:
    """Coordinates of the four-bars at an angle from upright."""
    s, c = np.sin(angle), np.cos(angle)
    turn = (np.cos(angle / 2), 0.0, 0.0, -np.sin(angle / 2))
    uprights = [(x + s / 2, c / 2, 0.0, *turn) for x in range(3)]
    couplers = [(x + 0.5 + s, c, 0.0, 1.0, 0.0, 0.0, 0.0) for x in range(2)]
    return np.concatenate([*uprights, *couplers])


def test_four_bars_branch_when_they_lie_flat() -> None:
    four_bars = system("four_bars")
    flat = sr.mobility(four_bars, flat_or_not(np.pi / 2))
    assert (flat.degrees_of_freedom, flat.kind, flat.finite) == (3, "branching", None)
    assert sr.mobility(four_bars, flat_or_not(1.5)).degrees_of_freedom == 1
    found = sr.singularities(four_bars, flat_or_not, np.linspace(1.0, 2.0, 8))
    assert [s.kind for s in found] == ["branch"]
    assert found[0].at == pytest.approx(np.pi / 2, abs=1e-8)


def test_accelerations_of_andrews_mechanism() -> None:
    """β̈ and θ̈ as in the Test Set for IVP Solvers; all other angles start with none."""
    run = instant("andrews")
    found = {
        name: system("andrews").joint(name)["angle"].acceleration(run.q[0], run.v[0], run.a[0])
        for name in ("beta", "theta", "gamma", "phi", "delta", "omega", "epsilon")
    }
    wanted = dict.fromkeys(found, 0.0) | {"beta": 14222.4439199541, "theta": -10666.8329399656}
    assert found == pytest.approx(wanted, rel=EXACT, abs=1e-6)


def test_bricard_says_which_equation_is_redundant() -> None:
    found = sr.mobility(system("bricard"))
    assert (found.equations, found.rank, found.kind) == (35, 34, "redundant")
    assert [one.joint for one in found.repetitions] == ["hinge_6"]
    assert "hinge_6 repeats hinge_1" in str(found)


def test_bricard_keeps_its_energy() -> None:
    run = exactly("bricard", 1.0, np.linspace(0, 1, 5))
    heights = sum(run[f"rod_{n}"].position[:, 1] for n in range(1, 6))
    energy = [system("bricard").kinetic_energy(q, v) for q, v in zip(run.q, run.v)] + G * heights
    assert energy == pytest.approx(np.full(5, -3 * G), rel=DIGITS)  # -29.43 J


BALL, ROD, CUBE, EYE, STIFFNESS = 5.0, 0.3, 3.0, 0.05, 8e5
THIN = 0.3 * 0.01**2 / 12  # [kg m²] of a rod's section


def governor_forces(s: float, alpha: float, spin: float) -> tuple[float, float]:
    """Derivatives by s and α of the potential less the centrifugal one: written in s and α, for a steady turn."""
    c, w = np.cos(alpha), np.sin(alpha)
    reach, drop = 0.5 * c, 1 - 0.5 * w - s
    length = np.hypot(reach, drop)
    tension = STIFFNESS * (length - 0.5)
    by_s = CUBE * G - 2 * tension * drop / length
    weight = -2 * G * (BALL + ROD / 2) * c
    spring = 2 * tension * (-reach * 0.5 * w - drop * 0.5 * c) / length
    balls = BALL * (EYE + c) * -w
    rods = ROD * (EYE * -w / 2 - c * w / 3) + THIN * c * w
    return by_s, weight + spring - spin**2 * 2 * (balls + rods)


@pytest.mark.parametrize("spin", [5.0, 6.2, 8.0])
def test_the_governor_turns_steadily_at_its_angle(spin: float) -> None:
    """The state with the angle of the closed form is a steady motion of the model."""
    s, alpha = fsolve(lambda z: governor_forces(*z, spin), (0.5, 0.5), xtol=1e-13)
    given = {"height": s, "alpha": alpha, "spin": spin}
    turning = sr.System(sr.load(FOLDER / "governor.yaml", parameters=given))
    found = sr.modes(turning, turning.q0, turning.v0, turning=(0, 0, spin))
    assert found.success, found.message
    assert found.steady < 1e-6


def test_energy_of_the_governor() -> None:
    """133.427950441526 J in the reference, heights of arms counted from their hinges and that of the slider from 0."""
    heights = -2 * (BALL + ROD / 2) * np.sin(np.pi / 6) + CUBE * 0.5
    assert kinetic("governor") + G * heights == pytest.approx(133.427950441526, rel=1e-12)


def test_the_heavy_top_at_its_start() -> None:
    run = instant("heavy_top")
    assert run.a[0, :3] == pytest.approx([0, -21.3017325444, -30.9608307692], rel=EXACT)
    assert run.reaction("tip").force[0] == pytest.approx([0, -319.525988166, -317.2624615385], rel=EXACT)
    assert kinetic("heavy_top") == pytest.approx(5435.696790865547, rel=1e-12)


def test_the_heavy_top_keeps_its_spin() -> None:
    run = exactly("heavy_top", 0.05, np.linspace(0, 0.05, 4))
    assert run["top"].angular_velocity_body[:, 1] == pytest.approx(np.full(4, 150.0), rel=DIGITS)


def sundials_force(q: float) -> float:
    """The force along q, as the example's equations give it: Q_q + Q_x x' + Q_p p', with x'(q) and p'(q)."""
    a = 0.5
    p = -np.arcsin(a * np.sin(q))
    x, dp = np.cos(p) + a * np.cos(q), -a * np.cos(q) / np.cos(p)
    dx = -np.sin(p) * dp - a * np.sin(q)
    l = np.sqrt(x**2 - x * (np.cos(p) + a * np.cos(q)) + (1 + a**2) / 4 + a / 2 * np.cos(p - q))
    f = l - 1
    by_q = -f / l * a * (np.sin(p - q) / 2 + x * np.sin(q)) / 2
    by_x = f / l * (np.cos(p) / 2 - x + a / 2 * np.cos(q)) + 1
    by_p = -f / l * (x * np.sin(p) - a / 2 * np.sin(p - q)) / 2 - np.sin(p)
    return float(by_q + by_x * dx + by_p * dp)


def test_acceleration_of_the_slider_crank_of_sundials() -> None:
    """At rest q̈ = force / (J1 + m2 x'² + J2 p'²); p' = 0 and x' = -1/2 where the crank stands upright."""
    run = instant("sundials_slider_crank")
    found = system("sundials_slider_crank").joint("pivot")["angle"].acceleration(run.q[0], run.v[0], run.a[0])
    assert found == pytest.approx(sundials_force(np.pi / 2) / 1.25, rel=EXACT)


def test_rest_of_the_slider_crank_of_sundials() -> None:
    rest = sr.equilibrium(system("sundials_slider_crank"))
    q = np.pi / 2 + system("sundials_slider_crank").joint("pivot").angle(rest.q)
    assert q == pytest.approx(brentq(sundials_force, q - 0.2, q + 0.2, xtol=1e-14), abs=EXACT)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("cross", ["x", "z"])
def test_the_spatial_slider_crank_between_its_dead_centres(cross: str) -> None:
    """The slider turns back where the pin is nearest to the line of sliding, and farthest from it."""
    name = f"spatial_slider_crank_{cross}"
    run = exactly(name, 0.75, np.linspace(0, 0.75, 76))
    columns = columns_of(name, run)
    y, z = 0.1 - 0.08 * np.sin(columns["theta"]), 0.12 + 0.08 * np.cos(columns["theta"])
    assert columns["x"] == pytest.approx(np.sqrt(0.09 - y**2 - z**2), abs=1e-11)
    assert columns["theta"][-1] > 2 * np.pi
    dead = sr.singularities(system(name), run, inputs=["slider.x"])
    ends = np.sqrt(0.09 - (np.hypot(0.1, 0.12) + np.array([-0.08, 0.08])) ** 2)
    where = system(name).coordinates_of("slider")
    assert {s.kind for s in dead} == {"dead centre"}
    assert sorted(s.q[where][0] for s in dead)[-1] == pytest.approx(max(ends), rel=1e-8)
    assert sorted(s.q[where][0] for s in dead)[0] == pytest.approx(min(ends), rel=1e-8)


@pytest.mark.parametrize(("cross", "energy"), [("x", 0.71589168), ("z", 0.716076)])
def test_energy_of_the_spatial_slider_crank(cross: str, energy: float) -> None:
    weights = G * (0.12 * 0.12 + 0.5 * 0.1)
    assert kinetic(f"spatial_slider_crank_{cross}") + weights == pytest.approx(energy, rel=1e-12)


def test_accelerations_of_the_double_pendulum() -> None:
    """M φ̈ = -g (3/2, 1/2) with M from both links' moments about the hinges, all angles 0."""
    run = instant("double_pendulum")
    wanted = np.linalg.solve([[1 + 1 / 4 + 1, 1 / 2], [1 / 2, 1 + 1 / 4]], [-15, -5])
    assert run.a[0, [1, 8]] == pytest.approx([wanted[0] / 2, wanted[0] + wanted[1] / 2], rel=EXACT)


def test_the_double_pendulum_hangs_and_swings() -> None:
    rest = sr.equilibrium(system("double_pendulum"))
    assert rest.q[[0, 1, 7, 8]] == pytest.approx([0, -0.5, 0, -1.5], abs=EXACT)
    mass = np.array([[1 + 1 / 4 + 1, 1 / 2], [1 / 2, 1 + 1 / 4]])
    squares = np.linalg.eigvals(np.linalg.solve(mass, np.diag([15.0, 5.0])))
    assert rest.squares == pytest.approx(sorted(squares), rel=EXACT)


def test_energy_of_the_double_pendulum_in_space() -> None:
    heights = 2 * system("double_pendulum_3d").q0[2] + 1.5 * system("double_pendulum_3d").q0[9]
    assert kinetic("double_pendulum_3d") + G * heights == pytest.approx(-6.16872528877, rel=1e-11)


def test_a_free_symmetric_body_turns_as_kane_says() -> None:
    """The closed form of T. R. Kane, P. W. Likins and D. A. Levinson, Spacecraft Dynamics, 1983."""
    moments, (x, y, z) = (0.04, 0.04, 0.02), (2.0, -3.0, 4.0)
    names = [f"{group}.{letter}" for group in "Jw" for letter in "xyz"]
    model = sr.load(FOLDER / "free_body.yaml", parameters=dict(zip(names, (*moments, x, y, z))))
    run = sr.simulate(
        sr.System(model), until=2.0, t_eval=[1.0, 2.0], method=sr.ODE("DOP853", rtol=1e-11, atol=1e-12)
    )
    p, s = np.sqrt(x**2 + y**2 + (z / 2) ** 2), z / 2
    a, b, c = p * run.t / 2, s * run.t / 2, z / 2 / p
    sa, ca, sb, cb = np.sin(a), np.cos(a), np.sin(b), np.cos(b)
    along = x * cb + y * sb, -x * sb + y * cb
    wanted = [-c * sa * sb + ca * cb, sa / p * along[0], sa / p * along[1], c * sa * cb + ca * sb]
    assert run["body"].euler == pytest.approx(np.transpose(wanted), abs=DIGITS)


def test_the_car_axis_starts_without_multipliers_of_its_bar() -> None:
    """As the Test Set says: the bar and the upright spring bear nothing at the start."""
    run = instant("car_axis")
    for joint in ("bar", "upright"):
        assert abs(run.reaction(joint).force).max() < 1e-9
    # weights, and the springs' forces of (0.5 - 0.5) * 1: both start unstretched
    assert run.a[0, [8, 15]] == pytest.approx([-1, -1], rel=EXACT)
