"""Runs that crawl, and runs that may not take longer or more steps than the user says, end with what they have."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.patience import within_by_the_clock

import sarrus as sr
from sarrus.analyses.dynamics.step_loop.loop import IN_A_ROW
from sarrus.analyses.dynamics.stepping.step_budget import WINDOW, WINDOWS, StepBudget, StepWatch
from sarrus.analyses.dynamics.stepping.stepper import RunFailure, Settings
from sarrus.analyses.dynamics.stepping.tolerance import Tolerances
from sarrus.analyses.progress import TimeLimit, monitor

LONG = sr.HHT(rtol=1e-6, atol=1e-8, first_step=0.002)
ORDER_TWO = {"method": sr.HHT(rtol=1e-6, atol=1e-8)}


def light_cart_pole(mass: float = 1e-6) -> sr.System:
    cart = sr.Body("cart", mass=mass, inertia=(1e-6, 1e-6, 1e-6))
    pole = sr.Body("pole", mass=1.0, inertia=(1e-12, 1e-12, 1e-12), position=(1, 0, 0))
    joints = [
        sr.Translational("track", sr.ground, cart, point=(0, 0, 0), axis=(1, 0, 0)),
        sr.Revolute("pin", cart, pole, point=(0, 0, 0), axis=(0, -1, 0)),
    ]
    return sr.System(sr.Model("light cart-pole", bodies=[cart, pole], joints=joints, gravity=(0, 0, -9.81)))


def spring(k: float, m: float = 1.0) -> sr.System:
    """A mass of 1 kg on a spring at its own length plus 1 cm, without damping; m is 1 m in the unit of length."""
    body = sr.Body("b", mass=1, inertia=(m**2,) * 3, position=(1.01 * m, 0, 0))
    return sr.System(
        sr.Model(
            "s",
            bodies=[body],
            joints=[sr.Translational("g", sr.ground, body, point=(1.01 * m, 0, 0), axis=(1, 0, 0))],
            forces=[sr.TSDA("t", sr.ground.point(0, 0, 0), body.point(0, 0, 0), k=k, length=m)],
        )
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "method", [sr.GeneralizedAlpha(1.0, stabilized=True), sr.HHT(alpha=0, stabilized=True)]
)
def test_a_run_that_crawls_ends_and_names_another_method(method: sr.HHT | sr.GeneralizedAlpha) -> None:
    fine = {"limits": sr.Limits(time=100.0)}
    # Steps of 1.4e-7 s: 3.5 million would lead to 1 s, which is below the limit, and 11 million to 2 s
    run = sr.simulate(light_cart_pole(), until=2.0, method=replace(method, rtol=1e-8, atol=1e-10), **fine)
    assert (run.success, run.status) == (False, "too many steps")
    assert "sr.Radau()" in run.message
    assert run.t[-1] > 0.4  # what was computed is there


@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", [sr.HHT(), sr.GeneralizedAlpha(), sr.Radau(), sr.ODE()])
def test_a_limit_of_steps_ends_every_method(method: sr.HHT) -> None:
    run = sr.simulate(spring(1e4), until=10.0, method=method, limits=sr.Limits(steps=50))
    assert run.status == "too many steps"
    assert run.nsteps == 50
    assert "Limits(steps=50): 50 steps were taken by t = " in run.message
    assert len(run.t) < 1001
    with pytest.raises(ValueError, match="steps must be 1"):
        sr.simulate(spring(1e4), until=10.0, limits=sr.Limits(steps=0))


def test_the_first_window_begins_at_the_start_of_the_run() -> None:
    """Of a run that starts at 1e6 s the first steps were 1e6 s long on average: one that crawls was seen later."""
    watch = StepWatch(StepBudget(longest=1.0), 1e6 + 1.0)
    watch.begin(1e6)
    for n in range(1, WINDOWS):
        watch.look(1e6 + n * WINDOW * 1e-8, n * WINDOW)
    with pytest.raises(RunFailure, match=r"1\.0e-08 s on average"):
        watch.look(1e6 + WINDOWS * WINDOW * 1e-8, WINDOWS * WINDOW)


def test_a_fixed_step_is_the_users_choice() -> None:
    run = sr.simulate(
        spring(100.0), until=1000.0, method=sr.HHT(step=1e-5), t_eval=[1000.0], limits=sr.Limits(time=1.0)
    )
    assert run.status == "time limit"  # 10⁸ steps would follow, and none of them is the error control's


@pytest.mark.parametrize("k", [1e7, 3e7, 1e8, 2e8, 5e8, 1e9])
def test_the_first_step_sees_a_stiff_spring_released_at_rest(k: float) -> None:
    run = sr.simulate(spring(k), until=1.0, limits=sr.Limits(steps=400))
    assert run.history[0, 1] * np.sqrt(k) < 0.5  # ω h; it was 20 for k = 1e8
    energy = run.kinetic_energy[: len(run.t)] + 0.5 * k * (run.coordinate("b.x") - 1.0) ** 2
    assert energy.max() < 1.01 * 0.5 * k * 1e-4


def test_a_time_limit_keeps_what_was_computed(tmp_path: object) -> None:
    with within_by_the_clock(5):
        run = sr.simulate(spring(1e8), until=10.0, limits=sr.Limits(time=0.05))
    assert run.status == "time limit"
    assert 0 < len(run.t) < 1001
    folder = f"{tmp_path}/run"
    cut = sr.simulate(spring(1e5), until=5.0, limits=sr.Limits(time=1e-3), save=folder)
    assert cut.status == "time limit"
    whole = sr.resume(folder)
    assert whole.success
    assert np.array_equal(whole.q, sr.simulate(spring(1e5), until=5.0).q)


def test_the_monitor_refuses_what_is_no_progress_and_no_limit() -> None:
    with pytest.raises(TypeError, match="progress must be True"), monitor(3):  # type: ignore[arg-type]
        pass
    for limit in (0.0, -1.0, float("nan")):
        with pytest.raises(ValueError, match=r"time must be a (positive|finite)"):
            sr.simulate(spring(1e4), until=1.0, limits=sr.Limits(time=limit))
    with pytest.raises(TimeLimit, match="time limit of 1e-09 s"), monitor(None, time_limit=1e-9) as report:
        report(0.0)


def test_energy_that_grows_from_nothing_is_a_warning() -> None:
    with pytest.warns(sr.SarrusWarning, match="total energy grew by .* more than its parts supply"):
        run = sr.simulate(spring(1e8), until=0.1, method=LONG)  # ω h = 20: 400 times the energy
    assert run.warnings
    with pytest.raises(sr.StrictError), sr.strict():
        sr.simulate(spring(1e8), until=0.1, method=LONG)
    small = replace(LONG, atol={"position": 1e-20, "orientation": 1e-8})  # the same with lengths in 10¹² m
    with pytest.warns(sr.SarrusWarning, match="total energy grew by"):
        sr.simulate(spring(1e8, 1e-12), until=0.1, method=small)


def stiffening(**more: object) -> sr.System:
    """The same with a stiffness over the length, as a table."""
    model, table = spring(1e8).model, [[0.0, 1e8], [1.0, 1e8], [2.0, 1.0000001e8], [1e3, 1.001e8]]
    law = sr.TSDA("t", *(model.forces[0].point_i, model.forces[0].point_j), k=table, length=1.0, **more)
    return sr.System(replace(model, forces=[law]))


def test_energy_of_a_spring_with_a_law_grows_from_nothing_too() -> None:
    given = {"until": 0.1, "method": LONG}
    with pytest.warns(sr.SarrusWarning, match="total energy grew by"):
        assert sr.simulate(stiffening(), **given).warnings
    for more in ({"force": "1e-9*t"}, {"c": 1e-9}):  # an actuator or a law for damping could put in work
        assert sr.simulate(stiffening(**more), **given).warnings == ()


def test_energy_that_grows_is_a_warning_of_saved_and_resumed_runs(tmp_path: Path) -> None:
    system, given = spring(1e8), {"until": 0.1, "method": LONG}

    def interrupt(t: float) -> None:
        raise KeyboardInterrupt

    assert sr.simulate(system, save=tmp_path / "cut", progress=interrupt, **given).warnings == ()
    with pytest.warns(sr.SarrusWarning, match="total energy grew by"):
        whole = sr.simulate(system, save=tmp_path / "whole", **given)
    runs = [whole, sr.load_run(tmp_path / "whole"), sr.resume(tmp_path / "whole")]
    for more in (sr.resume, sr.repeat):
        with pytest.warns(sr.SarrusWarning, match="total energy grew by"):
            runs.append(more(tmp_path / "cut"))
    for run in runs:
        assert "total energy grew by" in run.warnings[0]


@pytest.mark.one_in(2)
@pytest.mark.parametrize("inertia", [1e-6, 1e-12])
def test_an_explicit_method_passes_the_flip_of_a_light_cart(inertia: float) -> None:
    """As the pole hangs, cart and pole turn at 3000 rad/s and more: for 1e-4 s the steps are 1e-7 s long."""
    cart = sr.Body("cart", 1e-6, (1e-6, 1e-6, 1e-6))
    pole = sr.Body("pole", 1.0, (inertia, inertia, inertia), position=(1, 0, 0))
    joints = [
        sr.Translational("track", sr.ground, cart, point=(0, 0, 0), axis=(1, 0, 0)),
        sr.Revolute("pin", cart, pole, point=(0, 0, 0), axis=(0, -1, 0)),
    ]
    system = sr.System(sr.Model("cart", [cart, pole], joints, gravity=(0, 0, -9.81)))
    run = sr.simulate(system, until=1.0, method=sr.ODE(rtol=1e-8, atol=1e-10))
    assert run.success, run.message
    assert np.ptp(run.total_energy) < 1e-6
    assert run.coordinate("pole.z") == pytest.approx(_height(1e-6, inertia, run.t), abs=1e-5)


def _height(cart: float, inertia: float, times: np.ndarray) -> np.ndarray:
    """Height of the pole's mass of 1 kg, 1 m from the pin, by SciPy in x of the cart and the pole's angle below it."""

    def rate(t: float, y: np.ndarray) -> list[float]:
        _, turned, vx, w = y
        s, c = np.sin(turned), np.cos(turned)
        M = np.array([[cart + 1, -s], [-s, 1 + inertia]])
        return [vx, w, *np.linalg.solve(M, [c * w * w, 9.81 * c])]

    found = solve_ivp(rate, (0, 1), [0, 0, 0, 0], "DOP853", times, rtol=1e-10, atol=1e-12)
    height: np.ndarray = -np.sin(found.y[1])
    return height


def test_steps_that_are_rejected_without_end_end_the_run() -> None:
    """A search for a switch, whose retaken steps did not become shorter, was a call that never returned."""
    system = spring(1e4)
    start = sr.assemble(system)
    stepper = sr.Radau().stepper(system, start, Settings(Tolerances.of(system, 1e-6, 1e-9)))
    stepper.restart(0.0, start.q, start.v, 1.0)
    stepper._control.rejected_since = IN_A_ROW + 1
    with pytest.raises(RunFailure, match="steps become too small near t = 0 s"):
        stepper.advance(1.0, 10)
