"""Rolling without slip: motions, reactions and orders of the methods against closed forms and reduced equations."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.analyses.rolling import I_A, I_T, G, M, R, coin, leaning, sleigh, turntable, upright
from tests.analyses.test_descriptions import METHODS

import sarrus as sr

every = pytest.mark.parametrize("name", METHODS)
SLOPE, OMEGA = 0.3, (0.5, 6.0, 1.0)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("system", [sleigh(), upright(), leaning(0.25, OMEGA, k=5.0, c=0.3), turntable()],
                         ids=lambda system: system.name)  # fmt: skip
def test_all_operators_are_those_of_independent_routes(system: sr.System) -> None:
    report = system.check_derivatives()
    assert report.ok, report


@pytest.mark.one_in(8)
@pytest.mark.parametrize("kind", [sr.RollingWheel, sr.RollingDisc])
@every
def test_disc_rolls_down_an_incline(name: str, kind: type) -> None:
    """A = g sin / (1 + I/mr²), by friction m g sin I/(I + mr²); the centre of constant acceleration is exact."""
    system = upright(SLOPE, kind)
    run = sr.simulate(system, until=0.5, t_eval=[0.5], method=replace(METHODS[name], rtol=1e-7, atol=1e-9))
    ratio = I_A / (M * R**2)
    way = 0.5 * G * np.sin(SLOPE) / (1 + ratio) * 0.5**2
    plane = np.array([np.cos(SLOPE), 0.0, -np.sin(SLOPE)])
    assert (run.final.q[:3] - system.q0[:3]) @ plane == pytest.approx(way, rel=1e-5)
    force = run["rolls"].force[-1]
    assert force @ plane == pytest.approx(-M * G * np.sin(SLOPE) * ratio / (1 + ratio), rel=1e-6)
    assert force @ [np.sin(SLOPE), 0.0, np.cos(SLOPE)] == pytest.approx(M * G * np.cos(SLOPE), rel=1e-6)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("method", [sr.Radau(), sr.ODE("DOP853")])
def test_coin_moves_as_by_reduced_equations(method: Any) -> None:
    system = leaning(0.3, OMEGA)
    run = sr.simulate(system, until=1.5, t_eval=[1.5], method=replace(method, rtol=1e-10, atol=1e-12))
    assert np.allclose(run.final.q[:3], coin(0.3, OMEGA, 1.5), rtol=0, atol=1e-8)
    assert np.ptp(run.total_energy) < 1e-8


def test_steady_circle_of_a_coin_has_the_speed_of_the_closed_form() -> None:
    """Of lean θ, rate of turning Ω and radius of the path ρ of the centre, by d'Alembert about the contact."""
    lean, rho = 0.3, 0.8
    s, c = np.sin(lean), np.cos(lean)
    # spin about the axis w2 = -Ω ρ / R, about e3 Ω c; (I_A + m R²) w2 Ω c - I_T Ω² s c + m g R s = 0
    turn = np.sqrt(M * G * R * s / ((I_A + M * R**2) * rho / R * c + I_T * s * c))
    spin = -turn * rho / R
    omega = (0.0, spin * c - turn * c * s, spin * s + turn * c * c)
    run = sr.simulate(
        leaning(lean, omega), until=2.0, t_eval=np.linspace(0, 2, 21), method=sr.Radau(rtol=1e-9, atol=1e-11)
    )
    assert np.allclose(run["disc"].position[:, 2], R * c, atol=1e-8)
    x, y = run["disc"].position[:, :2].T
    center = np.array([0.0, np.sign(spin * turn) * -1.0 * rho])
    distance = np.hypot(x - center[0], y - center[1])
    other = np.hypot(x - center[0], y + center[1])
    assert min(abs(distance - rho).max(), abs(other - rho).max()) < 1e-7


@pytest.mark.slow
def test_sphere_on_a_turntable_moves_in_circles() -> None:
    """With 2/7 of the angular velocity of the table."""
    speed = 2.0
    system = turntable(speed)
    turn = 2 * np.pi / (2 / 7 * speed)
    t = np.linspace(0, turn, 17)
    run = sr.simulate(system, until=turn, t_eval=t, method=sr.Radau(rtol=1e-9, atol=1e-11))
    position, velocity = run["ball"].position[:, :2], run["ball"].velocity[:, :2]
    assert np.allclose(position[-1], position[0], atol=1e-7)
    acceleration = run["ball"].acceleration[:, :2]
    quarter = np.column_stack([-velocity[:, 1], velocity[:, 0]])
    assert np.allclose(acceleration, 2 / 7 * speed * quarter, atol=1e-7)


def test_sleigh_of_chaplygin() -> None:
    """v̇ = a ω², (I + m a²) ω̇ = -m a v ω: energy is kept, and v and ω are those of the tanh and sech."""
    a = 0.2
    system = sleigh(a)
    run = sr.simulate(system, until=2.0, t_eval=np.linspace(0, 2, 9), method=sr.Radau(rtol=1e-9, atol=1e-11))
    inertia = 0.15 + M * a**2
    v, w = 0.4, 1.5
    k = M * a / inertia
    top = np.sqrt(v**2 + a / k * w**2)  # v² + (a / k) ω² is constant
    rate, begin = k * top, np.arctanh(v / top)
    heading = run["plate"].angular_velocity_global[:, 2]
    assert np.allclose(heading, top * np.sqrt(k / a) / np.cosh(rate * run.t + begin), atol=1e-8)
    speed = np.hypot(*(run["plate"].velocity[:, :2]).T) ** 2 - (a * heading) ** 2
    assert np.allclose(np.sqrt(speed), top * np.tanh(rate * run.t + begin), atol=1e-8)
    side = M * run["plate"].acceleration
    assert np.allclose(run["edge"].force[:, :2], side[:, :2], atol=1e-7)


@pytest.mark.parametrize(("method", "order"), [(sr.HHT, 2), (sr.GeneralizedAlpha, 2)])
@pytest.mark.parametrize("stabilized", [False, True])
def test_order_of_the_methods(method: Any, order: int, stabilized: bool) -> None:
    system, errors = leaning(0.3, OMEGA), []
    exact = coin(0.3, OMEGA, 0.4)
    for step in (0.004, 0.002, 0.001):
        run = sr.simulate(
            system, until=0.4, t_eval=[0.4],
            method=replace(method(step=step, stabilized=stabilized), rtol=1e-10, atol=1e-12),
        )  # fmt: skip
        errors.append(np.linalg.norm(run.final.q[:3] - exact))
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(abs(slopes - order) < 0.1), (slopes, errors)


@every
def test_both_constraints_hold(name: str) -> None:
    system = leaning(0.25, OMEGA, k=5.0, c=0.3)
    run = sr.simulate(system, until=0.5, method=replace(METHODS[name], rtol=1e-6, atol=1e-8))
    for q, v in zip(run.q, run.v, strict=True):
        assert abs(system.Phi(q)).max() < 1e-9
        assert abs(system.Phi_q_xi(q, v)).max() < 1e-8


def test_velocities_are_assembled_and_positions_are_free_to_move() -> None:
    """A velocity that slips is changed; the position along the plane is as given."""
    system = leaning(0.25, OMEGA)
    q, v = system.q0.copy(), system.v0.copy()
    q[:2] += 0.7, -0.4
    v[:3] += 0.3
    with pytest.warns(sr.SarrusWarning, match="velocity"):
        start = sr.assemble(system, q, v)
    assert start.success
    assert np.allclose(start.q[:2], q[:2], atol=1e-14)
    assert abs(system.Phi_q_xi(start.q, start.v)).max() < 1e-14
    assert (system.m_holonomic, system.m) == (2, 4)


def test_modes_of_a_coin_that_rolls_straight() -> None:
    """Lean and heading: (I_T + m R²) θ̈ = m g R θ - (I_A + m R²) ω ψ̇, I_T ψ̇ = I_A ω θ."""
    spin = 5.0
    system = leaning(0.0, (0.0, spin, 0.0))
    found = sr.modes(system, sr.assemble(system))
    assert found.success, found.message
    square = (I_A / I_T * (I_A + M * R**2) * spin**2 - M * G * R) / (I_T + M * R**2)
    assert found.eigenvalues[-1] == pytest.approx(1j * np.sqrt(square), rel=1e-10)
    slow = leaning(0.0, (0.0, 0.5, 0.0))  # falls over
    assert sr.modes(slow, sr.assemble(slow)).stability == "unstable"


def test_mobility_counts_velocities_and_positions() -> None:
    coin, wheel = sr.mobility(leaning(0.25, OMEGA)), sr.mobility(upright())
    assert (coin.degrees_of_freedom, coin.configuration_dimension) == (3, 5)
    assert (wheel.degrees_of_freedom, wheel.configuration_dimension) == (2, 4)
    assert "2 degrees of freedom of the velocities, 4 of the positions" in wheel.summary()


@pytest.mark.parametrize("kind", [sr.RollingWheel, sr.RollingDisc])
def test_the_size_of_a_rolling_body_is_its_radius(kind: type) -> None:
    """Its centre is on the axis but for round-off, beside which its inertia is large."""
    assert upright(0.2, kind).warnings == ()


def test_mobility_counts_no_first_order_states() -> None:
    lag = sr.FirstOrderLag("lag", input="disc.velocity.x", time=0.1)
    found = sr.mobility(sr.System(replace(upright().model, forces=[lag])))
    assert (found.degrees_of_freedom, found.configuration_dimension) == (2, 4)


@pytest.mark.parametrize("analysis", [
    lambda system: sr.equilibrium(system),
    lambda system: sr.kinematics(system, [0.0, 1.0]),
    lambda system: sr.workspace(system, ("disc.x", "disc.y")),
])  # fmt: skip
def test_analyses_of_positions_are_refused_by_name(analysis: Any) -> None:
    with pytest.raises(sr.SarrusError, match=r"rolls: .*rolling without slip.*\."):
        analysis(upright())


def test_forces_of_a_motion_are_found_by_inverse_dynamics() -> None:
    system = upright(SLOPE)
    run = sr.simulate(system, until=0.3, method=sr.Radau(rtol=1e-9, atol=1e-11))
    found = sr.inverse_dynamics(system, run)
    assert found.success
    assert np.allclose(found["rolls"].force, run["rolls"].force, atol=1e-7)


def test_two_wheels_on_one_axle_repeat_each_other() -> None:
    """A cart with two rolling wheels and a skid: that neither wheel slips sideways is said twice."""
    cart = sr.Body("cart", mass=3, inertia=(0.2, 0.3, 0.4), position=(0, 0, R))
    wheels, joints = [], [sr.PointOnPlane("skid", sr.ground, cart, point=(0.5, 0, 0), axis=(0, 0, 1))]
    for name, y in (("left", 0.4), ("right", -0.4)):
        wheel = sr.Body(name, mass=1, inertia=(0.02, 0.04, 0.02), position=(0, y, R))
        joints.append(sr.Revolute(f"{name}_hub", cart, wheel, point=(0, y, R), axis=(0, 1, 0)))
        joints.append(sr.RollingDisc(f"{name}_rolls", center=wheel.point(0, 0, 0), radius=R, axis=(0, 1, 0),
                                     plane=sr.ground.frame((0, 0, 0))))  # fmt: skip
        wheels.append(wheel)
    push = sr.PointForce("push", cart.point(0.5, 0, 0), force=(1.0, 0.3, 0.0))
    system = sr.System(sr.Model("cart", [cart, *wheels], joints, forces=[push], gravity=(0, 0, -G)))
    mobility = sr.mobility(system)
    assert (mobility.degrees_of_freedom, mobility.redundant) == (2, 1)
    assert mobility.repetitions[0].joint == "right_rolls"
    ends = []
    for method in (sr.HHT(), sr.HHT(stabilized=True), sr.Radau(), sr.ODE("DOP853")):
        run = sr.simulate(system, until=0.5, method=replace(method, rtol=1e-7, atol=1e-9))
        assert run.success
        q, v = run.final.q, run.final.v
        assert abs(system.Phi_q_xi(q, v)).max() < 1e-8
        ends.append(q)
    assert np.allclose(ends, ends[2], atol=1e-5)


def test_the_matrix_is_as_well_scaled_as_without_rolling() -> None:
    """However short the step is: entries of B do not grow with 1/h."""
    from sarrus.analyses.dynamics.methods.description import NONHOLONOMIC
    from sarrus.analyses.dynamics.methods.nonholonomic import method_for

    system = leaning(0.3, OMEGA)
    for method in (
        sr.HHT().description,
        sr.GeneralizedAlpha(0.7).description,
        METHODS["implicit_midpoint"].description,
        METHODS["bdf2"].description,
    ):
        for h in (1e-2, 1e-6):
            step = method_for(system, method).step(h, 1.0)
            sizes = {}
            for one in step.equations:
                stage = step.stages[one.stage]
                by = stage.q if one.kind == "position" else stage.v
                if one.kind in ("position", "velocity"):
                    factor = max(abs(one.scale * c) for name, c in by.items() if name in method.unknowns)
                    sizes[one.kind, one.rows == NONHOLONOMIC] = factor
            assert sizes["velocity", True] == pytest.approx(sizes["position", False], rel=1e-12)


def test_a_disc_that_lies_flat_is_refused() -> None:
    with pytest.raises(sr.ModelError, match='joint "rolls": axis is along the normal'):
        leaning(np.pi / 2, OMEGA)
