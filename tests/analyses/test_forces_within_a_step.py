"""Forces that set in and end within a step of a calm motion are not passed over."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import sarrus as sr
from sarrus.analyses.dynamics.time_loop import recording, time_loop
from sarrus.functions import sin

SPEED, RADIUS, K, BEGIN = 10.0, 0.2, 1e6, -19.37


def pass_by(offset: float) -> sr.System:
    """A mass that flies past the origin and is kept at a distance of 0.2 m from it by an elastic stop."""
    body = sr.Body("b", mass=1.0, inertia=(0.004,) * 3, position=(BEGIN, offset, 0), velocity=(SPEED, 0, 0))
    stop = sr.LengthStop(
        "stop", sr.ground.point(0, 0, 0), body.point(0, 0, 0), lower=RADIUS, stiffness=K, rounding=1e-7
    )
    return sr.System(sr.Model("pass", [body], [], [stop]))


def deflected(offset: float, until: float) -> np.ndarray:
    """Where the mass is then, by SciPy from the touch until it leaves, without rounding."""
    integrate = pytest.importorskip("scipy.integrate")

    def rates(_: float, y: np.ndarray) -> list[float]:
        r = float(np.hypot(y[0], y[1]))
        return [y[2], y[3], *(K * max(RADIUS - r, 0.0) * y[:2] / r)]

    def leaves(t: float, y: np.ndarray) -> float:
        return float(np.hypot(y[0], y[1]) - RADIUS) if t > 1e-5 else -1.0

    leaves.terminal = True  # type: ignore[attr-defined]
    x = -np.sqrt(RADIUS**2 - offset**2)
    begin = [x, offset, SPEED, 0.0]
    run = integrate.solve_ivp(rates, (0, 1), begin, rtol=1e-12, atol=1e-14, method="DOP853", events=leaves)
    at, rate = run.y[:2, -1], run.y[2:, -1]
    return np.asarray(at + rate * (until - (x - BEGIN) / SPEED - run.t[-1]))


@pytest.mark.one_in(8)
@pytest.mark.parametrize(
    ("settings", "near"),
    [
        ({}, 1e-6), ({"method": sr.ODE()}, 3e-6), ({"store": "steps"}, 1e-6),
        ({"method": sr.HHT(rtol=1e-8)}, 3e-3), ({"method": sr.GeneralizedAlpha(rtol=1e-8)}, 3e-3),
    ],
    ids=["default", "ODE", "stored", "HHT", "generalized-alpha"],
)  # fmt: skip
@pytest.mark.parametrize("offset", [0.19, 0.199, 0.1999])
def test_a_touch_of_milliseconds_in_a_flight_of_seconds(
    offset: float, settings: dict[str, Any], near: float
) -> None:
    run = sr.simulate(pass_by(offset), until=4.0, **settings)
    wanted = deflected(offset, 4.0)
    assert wanted[1] > 1.5 * offset
    assert run["b"].position[-1, :2] == pytest.approx(wanted, rel=0, abs=near * 40)
    assert run.nsteps < 400


@pytest.mark.parametrize(
    ("method", "near"), [(sr.Radau(), 2e-7), (sr.ODE(), 3e-7), (sr.HHT(), 5e-4)], ids=["Radau", "ODE", "HHT"]
)
@pytest.mark.parametrize("speed", [0.003, 0.01])
def test_a_mass_thrown_up_hardly_reaches_a_stop(speed: float, method: Any, near: float) -> None:
    """It touches at a speed that is 3e-3 of what it loses within a step, and turns 2 ms earlier than without a stop."""
    g, way, stiffness = 9.81, 1.6, 1e6
    thrown, omega = np.sqrt(2 * g * way + speed**2), np.sqrt(stiffness)
    body = sr.Body("b", 1.0, (0.004,) * 3, position=(0, 0, 1), velocity=(0, 0, thrown))
    guide = sr.Translational("guide", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
    ends = sr.ground.point(0, 0, 0), body.point(0, 0, 0)
    stop = sr.LengthStop("stop", *ends, upper=1 + way, stiffness=stiffness, rounding=1e-7)
    system = sr.System(sr.Model("thrown", [body], [guide], [stop], gravity=(0, 0, -g)))
    run = sr.simulate(system, until=1.0, method=method)
    touch = 2 / omega * np.arctan2(speed * omega, g)
    t = 1.0 - (thrown - speed) / g - touch
    assert abs(run["b.z"][-1] - (1 + way - speed * t - g * t**2 / 2)) < near


@pytest.mark.parametrize("store", ["samples", "steps"])
def test_a_function_that_has_come_to_zero_ends_no_steps(store: str) -> None:
    """u comes to 0.7, and u - 0.7 changes its sign with round-off, in steps that a vibration keeps short."""
    bodies = [sr.Body("b", 1.0, (1, 1, 1)), sr.Body("c", 1.0, (1, 1, 1), velocity=(0, 1, 0))]
    axes = {"b": (1, 0, 0), "c": (0, 1, 0)}
    guides = [
        sr.Translational(b.name.upper(), sr.ground, b, point=(0, 0, 0), axis=axes[b.name]) for b in bodies
    ]
    lag = sr.StateVariable("u", rate="(0.7 - u)/0.02", initial=0.0)
    laws = {"B": "10*max(u - 0.7, 0)", "C": "-100*C.displacement"}
    forces = [sr.Force(f"on_{joint}", joint=joint, value=law) for joint, law in laws.items()]
    run = sr.simulate(sr.System(sr.Model("lag", bodies, guides, [lag, *forces])), until=20.0, store=store)
    assert run.nsteps > 1000
    assert run.nrejected < 0.1 * run.nsteps


def test_a_miss_is_a_miss() -> None:
    run = sr.simulate(pass_by(0.2001), until=4.0)
    assert run["b"].position[-1, :2] == pytest.approx([BEGIN + 40, 0.2001], abs=1e-9)
    assert run.nsteps < 20


@pytest.mark.slow
@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT(), sr.ODE()], ids=["Radau", "HHT", "ODE"])
def test_a_run_that_goes_on_takes_the_same_steps(
    method: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Saved before the touch, within it and after it."""
    monkeypatch.setattr(recording, "PAUSE", 0.0)
    monkeypatch.setattr(recording, "PATIENT", 0.0)
    monkeypatch.setattr(time_loop, "CHUNK", 4)
    system, reached = pass_by(0.19), list[float]()
    given = {"until": 4.0, "method": method}
    whole = sr.simulate(system, progress=reached.append, **given)
    for count in range(1, len(reached), 2):
        calls = list[float]()

        def stop(t: float, calls: list[float] = calls, count: int = count) -> None:
            calls.append(t)
            if len(calls) > count:
                raise KeyboardInterrupt

        folder = tmp_path / f"run{count}"
        assert sr.simulate(system, save=folder, progress=stop, **given).status == "stopped"
        assert np.array_equal(sr.resume(folder).q, whole.q), count


def washboard(speed: float, height: float, length: float, k: float, c: float) -> tuple[sr.System, Any]:
    """A sprung wheel of 20 kg over a road height sin(2π x / length), and its exact rates z, ż → ż, z̈."""
    mass, width, wave = 20.0, 1e-3, 2 * np.pi / length
    wheel = sr.Body("wheel", mass, (0.5,) * 3, position=(0, 0, 0.3))
    frame = sr.Body("frame", 5.0, (0.5,) * 3, position=(0, 0, 1))
    joints = [
        sr.Translational("along", sr.ground, frame, point=(0, 0, 1), axis=(1, 0, 0)),
        sr.Translational("up", frame, wheel, point=(0, 0, 0.3), axis=(0, 0, 1)),
    ]
    tyre = sr.RoadTyre(
        "tyre",
        wheel.point(0, 0, 0),
        k=k,
        c=c,
        radius=0.3,
        road=lambda x: height * sin(wave * x),
        rounding=width,
    )
    spring = sr.TSDA("spring", frame.point(0, 0, 0), wheel.point(0, 0, 0), k=2e3, c=50.0, length=0.9)
    driver = sr.DisplacementDriver("engine", "along", motion=lambda t: speed * t)
    model = sr.Model(
        "washboard", [frame, wheel], joints, [tyre, spring], drivers=[driver], gravity=(0, 0, -9.81)
    )

    def rates(t: float, y: Any) -> list[float]:
        phase = wave * speed * t
        depth = 0.3 - y[0] + height * np.sin(phase)
        rate = height * wave * speed * np.cos(phase) - y[1]
        s, u = (min(max(x + 0.5, 0.0), 1.0) for x in (depth / width, (k * depth + c * rate) / (k * width)))
        ramp = k * width * (u**3 - u**4 / 2) + max(k * depth + c * rate - k * width / 2, 0.0)
        force = s * s * (3 - 2 * s) * ramp + 2e3 * (0.1 - y[0]) - 50 * y[1]
        return [y[1], force / mass - 9.81]

    return sr.System(model), rates


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    ("speed", "height", "length", "k", "c"),
    [
        (
            50.0,
            0.01,
            0.05,
            1e6,
            200.0,
        ),  # grazes the crests: the force sets in by the depth, and ends by its rate
        (20.0, 0.02, 0.5, 2e5, 500.0),
        (30.0, 0.03, 0.3, 1e6, 0.0),
    ],
)
def test_a_wheel_that_leaves_and_touches_a_washboard_road(
    speed: float, height: float, length: float, k: float, c: float
) -> None:
    system, rates = washboard(speed, height, length, k, c)
    run = sr.simulate(
        system, until=0.1, method=sr.Radau(max_step=length / speed / 4)
    )  # a formula over the place has no points
    step = length / speed / 30
    exact = solve_ivp(rates, (0, 0.1), [0.3, 0.0], "DOP853", rtol=1e-11, atol=1e-13, max_step=step).y[0, -1]
    z = run["wheel"].position[:, 2]
    assert abs(z[-1] - exact) < 5e-4 * np.ptp(z)  # where it grazes, 2e-4, which changes with the steps
