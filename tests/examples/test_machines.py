"""The worked examples of machines with motors and controllers agree with reduced equations and closed forms."""

import runpy
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from tests.examples.problems import FOLDER

import sarrus as sr
from sarrus.model.written import with_numbers


def of(script: str) -> dict[str, Any]:
    """The names that a script defines."""
    return runpy.run_path(str(FOLDER / f"{script}.py"))


def reduced_servo(gains: Any, until: float) -> Any:
    """The angle of the crank from above, its rate, current, integral, filtered error and cost over time, by SciPy."""
    R, L, aim, imaginary = 0.1, 0.3, -0.07, 1e-30
    crank, rod = (0.5 / 12 * (3 / 40**2 + 1) * length**2 for length in (R, L))  # of round rods

    def slider(angle: Any) -> Any:
        return np.sqrt(L**2 - (R * np.cos(angle)) ** 2) - R * np.sin(angle)

    def inertia(angle: Any) -> Any:
        sine, cosine = np.sin(angle), np.cos(angle)
        tilt = R * sine / np.sqrt(L**2 - (R * cosine) ** 2)
        x = R * cosine * (tilt - 1)
        middle = ((x - R * cosine) / 2) ** 2 + (R * sine / 2) ** 2
        return crank + 0.5 * R**2 / 4 + 0.5 * middle + rod * tilt**2 + 2.0 * x**2

    def rates(t: float, y: Any) -> list[float]:
        angle, speed, current, integral, filtered, _ = y
        away = slider(angle) - slider(0.0)
        s = min(t / 0.1, 1.0)
        error = away - aim * s * s * (3 - 2 * s)
        slope = (error - filtered) / 5e-3
        voltage = gains @ [error, integral, slope]
        M, M_angle = inertia(angle), inertia(angle + 1j * imaginary).imag / imaginary
        torque = 0.5 * current + 9.81 * R * (0.5 + 0.5) / 2 * np.sin(angle) - M_angle * speed**2 / 2
        rate = (voltage - 0.8 * current - 0.5 * speed) / 1e-3
        return [speed, torque / M, rate, error, slope, t * (1e3 * (away - aim)) ** 2]

    options: Any = {"method": "LSODA", "rtol": 1e-10, "atol": 1e-12}
    first = solve_ivp(rates, (0, 0.1), np.zeros(6), t_eval=np.linspace(0, 0.1, 5001), **options)
    return first.y, solve_ivp(rates, (0.1, until), first.y[:, -1], **options).y[:, -1]


@pytest.mark.slow
def test_slider_crank_servo(tmp_path: Path) -> None:
    """In the equation of the angle, cost and current are the same, and no other gains are better: ∇J = -μ ∇P."""
    script = of("slider_crank_servo")
    best = script["main"](tmp_path)
    assert best.success
    assert (tmp_path / "slider_crank_servo.png").stat().st_size > 5000

    def cost_and_current(gains: Any) -> Any:
        first, end = reduced_servo(gains, script["UNTIL"])
        return np.array([end[5], first[2].max()])

    assert cost_and_current(best.x) == pytest.approx([best.value, script["MOST"]], rel=1e-5)
    changes = 1e-3 * np.diag(best.x)
    slopes = np.array([cost_and_current(best.x + d) - cost_and_current(best.x - d) for d in changes]).T
    multiplier = -(slopes[0] @ slopes[1]) / (slopes[1] @ slopes[1])
    assert multiplier > 0
    assert np.linalg.norm(slopes[0] + multiplier * slopes[1]) < 0.01 * np.linalg.norm(slopes[0])


@pytest.mark.slow
def test_active_suspension(tmp_path: Path) -> None:
    """The poles of the state space that is closed by hand are those of the vehicle with controlled actuators."""
    script = of("active_suspension")
    poles, gain, runs = script["main"](tmp_path)
    (chosen,) = np.flatnonzero(script["GAINS"] == gain)
    system = script["skyhook"](gain)
    known = sr.modes(system, sr.equilibrium(system)).eigenvalues
    for pole in poles[chosen][abs(poles[chosen]) > 1e-3]:
        assert min(abs(known - pole), default=1) < 1e-6 * abs(pole) or pole.imag < 0
    passive, active = (np.std(run[script["SEAT"]]) for run in runs.values())
    assert active < 0.5 * passive
    assert (tmp_path / "active_suspension.png").stat().st_size > 5000


def reduced_motor(b: Any, times: Any) -> Any:
    """Current and angle (2, nt) of the motor with its arm, by SciPy."""
    resistance, inductance, constant, friction, rotor = b
    arm = 0.6 * 0.3**2 * (1 / 3 + 3 / 40**2 / 12) + rotor

    def rates(t: float, y: Any) -> list[float]:
        current, angle, speed = y
        torque = 8 * constant * current - friction * speed - 0.6 * 9.81 * 0.15 * np.sin(angle)
        voltage = 12 * np.sin(6 * t + 8 * t**2)
        rate = (voltage - resistance * current - 8 * constant * speed) / inductance
        return [rate, speed, torque / arm]

    found = solve_ivp(rates, (0, times[-1]), np.zeros(3), t_eval=times, rtol=1e-10, atol=1e-12)
    return found.y[:2]


@pytest.mark.slow
def test_motor_constants(tmp_path: Path) -> None:
    """The intervals contain the true constants, and are those of the Jacobian of the reduced equations."""
    script = of("motor_constants")
    found = script["main"](tmp_path)
    true = np.array([*script["TRUE"].values()]) * [1, 1, 1, 1, script["GEAR"] ** 2]
    deviations = np.sqrt(np.diag(found.covariance))
    assert np.all(abs(found.x - true) < 3 * deviations)
    sigmas = np.array([*script["SENSORS"].values()])[:, None]
    columns = []
    for change in 1e-4 * np.diag(found.x):
        above, below = (reduced_motor(found.x + sign * change, script["TIMES"]) for sign in (1, -1))
        columns.append(((above - below) / sigmas).ravel() / (2 * change.sum()))
    jacobian = np.array(columns).T
    assert found.covariance == pytest.approx(np.linalg.inv(jacobian.T @ jacobian), rel=1e-3)
    assert (tmp_path / "motor_constants.png").stat().st_size > 5000


def reduced_lift(until: float) -> Any:
    """Height and pressures (3,) at the end by virtual work in the angle of the bars, by SciPy."""
    L, attached, m, bar, bottom = 2.0, 1.2, 500.0, 40.0, 2.0 * np.sin(np.radians(15))
    a, b, area, rod, dead, leakage = 0.8, attached, 7.85e-3, 4e-3, 1e-4, 5e-12
    across = 2 * bar * L**2 * (1 / 4 + (1 + 3 / 40**2) / 12)

    def flow(opening: float, drop: float) -> float:
        return opening * 5e-4 * drop / np.sqrt(35e5 * np.sqrt(drop**2 + 1e8))

    def rates(t: float, y: Any) -> list[float]:
        angle, speed, p_a, p_b = y
        sine, cosine = np.sin(angle), np.cos(angle)
        length = np.hypot(a * cosine, b * sine)
        lever = (b**2 - a**2) * sine * cosine / length
        s = np.clip((t - 0.5) / 4, 0, 1)
        u = np.clip(10 * (bottom + 0.8 * s * s * (3 - 2 * s) - L * sine), -1, 1)
        ahead, back = (np.hypot(u, 1e-3) + u) / 2, (np.hypot(u, 1e-3) - u) / 2
        q_a = flow(ahead, 160e5 - p_a) - flow(back, p_a) - leakage * (p_a - p_b) - area * lever * speed
        q_b = flow(back, 160e5 - p_b) - flow(ahead, p_b) + leakage * (p_a - p_b) + rod * lever * speed
        x = length - 0.8
        force = (area * p_a - rod * p_b) * lever - 9.81 * (m + bar) * L * cosine
        inertia = across + m * (L * cosine) ** 2
        rate = (force + m * L**2 * sine * cosine * speed**2) / inertia
        return [speed, rate, 1.4e9 * q_a / (dead + area * x), 1.4e9 * q_b / (dead + rod * (0.3 - x))]

    y, corners = (
        np.array([np.radians(15), 0, 64.5e5, 20e5]),
        [0, *(t for t in (0.5, 4.5) if t < until), until],
    )
    for span in pairwise(corners):
        y = solve_ivp(rates, span, y, method="LSODA", rtol=1e-8, atol=[1e-9, 1e-8, 1, 1]).y[:, -1]
    return np.array([L * np.sin(y[0]), *y[2:]])


def test_scissor_lift(tmp_path: Path) -> None:
    """Height and pressures are those of the lift in one coordinate, while it moves and in the end."""
    script = of("scissor_lift")
    run = script["main"](tmp_path)
    assert run.success
    assert sr.mobility(run.system).degrees_of_freedom == 1
    for t in (2.0, script["UNTIL"]):
        names = ("platform.z", "cylinder.pressure_a", "cylinder.pressure_b")
        found = [np.interp(t, run.t, run[name]) for name in names]
        assert found == pytest.approx(reduced_lift(t), rel=2e-4)
    assert (tmp_path / "scissor_lift.png").stat().st_size > 5000


class ReducedFiveBar:
    """The five-bar in the angles of its cranks, with the variations of its motion, by SciPy."""

    start = np.radians([120, 60])

    def points(self, q: Any) -> tuple[Any, Any]:
        """Both elbows and the tip, as rows."""
        feet = np.array([[-0.1, 0], [0.1, 0]])
        elbows = feet + 0.25 * np.array([np.cos(self.start + q), np.sin(self.start + q)]).T
        d = elbows[1] - elbows[0]
        far = np.sqrt(d @ d)
        return elbows, elbows.mean(axis=0) + np.sqrt(0.4**2 - far**2 / 4) * np.array([-d[1], d[0]]) / far

    def inertia(self, q: Any) -> Any:
        """The mass matrix (2, 2)."""
        round_rod, small = 1 + 3 / 40**2, 1e-30
        moved = [self.points(q + 1j * small * np.eye(2)[k]) for k in range(2)]
        elbows, tip = (np.array([one[n].imag / small for one in moved]) for n in range(2))
        (at, end), M = self.points(q), np.eye(2) * (0.25**2 / 4 + round_rod * 0.25**2 / 12)
        for side in range(2):
            middle, d, apart = (elbows[:, side] + tip) / 2, end - at[side], tip - elbows[:, side]
            turned = (d[0] * apart[:, 1] - d[1] * apart[:, 0]) / 0.4**2
            M = M + 0.8 * (middle @ middle.T + round_rod * 0.4**2 / 12 * np.outer(turned, turned))
        return M

    def rates(self, y: Any, u: Any) -> Any:
        """Rates (4,) of angles and speeds."""
        q, v, h = y[:2], y[2:], 1e-5
        M_q = [(self.inertia(q + d) - self.inertia(q - d)) / (2 * h) for d in h * np.eye(2)]
        loads = u - (M_q[0] * v[0] + M_q[1] * v[1]) @ v + np.array([v @ one @ v for one in M_q]) / 2
        return np.concatenate([v, np.linalg.solve(self.inertia(q), loads)])

    def influence(self, torque: Any, times: Any) -> tuple[Any, Any]:
        """The end (4,), and how impulses of both torques at times change it (nt, 4, 2)."""
        steps = 1e-6 * np.eye(4)

        def both(t: float, z: Any) -> Any:
            y, X, u = z[:4], z[4:].reshape(4, 4), torque(t)
            A = [(self.rates(y + d, u) - self.rates(y - d, u)) / 2e-6 for d in steps]
            return np.concatenate([self.rates(y, u), (np.array(A).T @ X).ravel()])

        z, found = np.concatenate([np.zeros(4), np.eye(4).ravel()]), []
        for span in pairwise(times):  # torques jump at some of the times alone
            inner = (span[0] + 1e-12, span[1] - 1e-12)
            found.append(z)
            z = solve_ivp(both, inner, z, rtol=1e-7, atol=1e-9).y[:, -1]
        end = z[4:].reshape(4, 4)
        inputs = [np.vstack([np.zeros((2, 2)), np.linalg.inv(self.inertia(one[:2]))]) for one in [*found, z]]
        states = [one[4:].reshape(4, 4) for one in [*found, z]]
        return z[:4], np.array([end @ np.linalg.solve(X, B) for X, B in zip(states, inputs, strict=True)])


@pytest.mark.slow
def test_five_bar_optimal(tmp_path: Path) -> None:
    """Pontryagin's principle: least energy where u = -½ Bᵀλ, least time where signs are those of -Bᵀλ."""
    script, reduced = of("five_bar_optimal"), ReducedFiveBar()
    energy, time = script["main"](tmp_path)
    assert energy.success
    assert time.success
    goal = [*script["GOAL"].values(), 0, 0]

    nodes = np.linspace(0, script["DURATION"], script["NODES"])
    table = CubicSpline(nodes, energy.x.reshape(2, -1).T)
    times = np.linspace(0, script["DURATION"], 26)
    end, influence = reduced.influence(table, times)
    assert end == pytest.approx(goal, abs=1e-4)
    columns, torques = influence.transpose(0, 2, 1).reshape(-1, 4), table(times).ravel()
    costate = np.linalg.lstsq(columns, torques, rcond=None)[0]
    assert np.linalg.norm(columns @ costate - torques) < 0.02 * np.linalg.norm(torques)

    factor = script["MOST"] * time["square"]
    changes = [
        script["switches"](dict(zip(time.names, time.x, strict=True)), side) for side in script["GOAL"]
    ]
    switches = [(t, motor) for motor, times in enumerate(changes) for t in times]

    def torque(t: float) -> Any:
        return factor * np.array([2 * (np.searchsorted(times, t) % 2) - 1 for times in changes])

    times = np.unique([*np.linspace(0, 1, 21), *(t for t, _ in switches)])
    end, influence = reduced.influence(torque, times)
    assert end == pytest.approx(goal, abs=1e-4)
    conditions = np.array([influence[np.searchsorted(times, t), :, motor] for t, motor in switches])
    _, sizes, directions = np.linalg.svd(conditions / np.linalg.norm(conditions, axis=1)[:, None])
    assert sizes[-1] < 1e-2 * sizes[-2]  # four conditions, but a costate for all of them
    switching = influence.transpose(0, 2, 1) @ directions[-1]
    sign = np.sign(switching[0, 0])
    for t, sigma in zip(times, sign * switching, strict=True):
        for motor in range(2):
            if min(abs(t - at) for at in changes[motor]) > 1e-9:
                assert sigma[motor] * torque(t - 1e-9)[motor] < 0 or t == 0
    costate = sign * directions[-1]
    assert costate @ reduced.rates(end, torque(1 - 1e-6)) < 0  # H = 1 + λᵀẏ = 0
    assert (tmp_path / "five_bar_optimal.png").stat().st_size > 5000


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("ki", "begin"), [(0.0, 0.0), (0.0, 0.45), (5.0, 0.0), (5.0, 0.45)])
def test_the_scissor_lift_stays_in_its_equilibrium(ki: float, begin: float) -> None:
    """Pressures of 1e7 N/m² and heights of 1 m in one search, also from a run.

    The integral of a controller without ki is at rest; with ki, pressures follow the position and the integral.
    """
    script = of("scissor_lift")
    model = script["lift"]().model
    parts = [replace(one, ki=ki) if isinstance(one, sr.PID) else one for one in model.forces]
    system = sr.System(replace(model, forces=parts))
    rest = sr.equilibrium(system, sr.simulate(system, until=begin).final if begin else None)
    assert rest.success
    assert rest["platform.z"] == pytest.approx(
        script["BOTTOM"] - rest["valve.output"] / 10 * (ki == 0), abs=1e-9
    )
    if begin:
        return
    run = sr.simulate(system, until=0.4, start=rest)
    assert np.ptp(run["platform.z"]) < 1e-9
    assert np.ptp(run["cylinder.pressure_a"]) < 1e-7 * rest["cylinder.pressure_a"]


@pytest.mark.slow
def test_engine_mounts(tmp_path: Path) -> None:
    """The placed frequencies are wanted ones and poles of the linearization; derivatives are differences."""
    script = of("engine_mounts")
    best, after = script["main"](tmp_path)
    assert best.success
    wanted = list(script["WANTED"].values())
    assert after.frequencies[11:14] == pytest.approx(wanted, abs=5e-4)  # converged by the default tolerance
    placed = sr.System(best.model)
    poles = np.linalg.eigvals(sr.linearize(placed, sr.equilibrium(placed)).A)
    for frequency in wanted:
        assert abs(poles.imag / (2 * np.pi) - frequency).min() < 1e-5
    system, start, h = script["vehicle"](), script["START"], 200.0
    slopes = sr.sensitivity(
        sr.modes(system, sr.equilibrium(system)),
        [*script["WANTED"]],
        design=start,
        formula=script["stiffnesses"],
    )
    moved = [
        _frequencies(system.model, script["stiffnesses"](start | {"vertical": 6.5e5 + d})) for d in (-h, h)
    ]
    assert slopes.matrix[:, slopes.names.index("vertical")] == pytest.approx(
        (moved[1] - moved[0]) / (2 * h), rel=1e-6
    )
    assert (tmp_path / "engine_mounts.png").stat().st_size > 5000


def _frequencies(model: sr.Model, changes: dict[str, float]) -> np.ndarray[Any, Any]:
    """Frequencies of roll, pitch and bounce of the engine."""
    system = sr.System(with_numbers(model, changes))
    return np.asarray(sr.modes(system, sr.equilibrium(system)).frequencies[11:14])


def ram_position(bearing: Any, crank: Any, top: Any, bottom: Any, ram: Any, t: float) -> Any:
    """The position of the ram over the dimensions of the press: z = z_0 - r cos φ - √(l² - r² sin² φ) - d."""
    r, length, phi = -crank, top - bottom, 2 * np.pi * t
    return bearing - r * np.cos(phi) - np.sqrt(length**2 - (r * np.sin(phi)) ** 2) - ram


@pytest.mark.slow
def test_press_tolerances(tmp_path: Path) -> None:
    """Variances are those of random samples of the closed form, in all and for each part."""
    script = of("press_tolerances")
    found, times, parts = script["main"](tmp_path)
    widths = 1e-3 / 3 * np.array([width for _, width in script["DIMENSIONS"].values()])
    means = np.array([mean for mean, _ in script["DIMENSIONS"].values()])
    assert found.std == pytest.approx([np.linalg.norm(widths), 2 * widths[1]], rel=1e-6)
    samples = means + widths * np.random.default_rng(1).normal(size=(400_000, 5))
    for n in (0, 12, 24, 36):
        total = sum(one[n] for one in parts.values())
        assert np.var(ram_position(*samples.T, times[n])) == pytest.approx(total, rel=1e-2)
        slope = np.imag(ram_position(*(means + 1e-30j * np.eye(5)[1]), times[n])) / 1e-30
        assert parts["crank"][n] == pytest.approx((slope * widths[1]) ** 2, rel=1e-6, abs=1e-20)
    assert (tmp_path / "press_tolerances.png").stat().st_size > 5000
