"""Motions go smoothly over positions where constraints become dependent; what is no smooth motion is refused."""

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from examples.four_bars import four_bars
from scipy.integrate import solve_ivp
from tests.analyses import linkages
from tests.examples.problems import system

import sarrus as sr

pytestmark = pytest.mark.filterwarnings(
    "ignore:.*a singular configuration is passed"
)  # as in all of these runs
G = 9.81
TIMES = np.linspace(0, 1.5, 31)  # all links lie in one line at 0.71 and at 1.23 s


def turned(n: int, times: np.ndarray) -> np.ndarray:
    """The angle from the vertical of n parallel four-bars: that of a pendulum."""
    c = G * ((n + 1) / 2 + n) / ((n + 1) / 3 + n)
    settings = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13, "t_eval": times}
    return solve_ivp(lambda t, y: [y[1], c * np.sin(y[0])], (0, times[-1]), [0, 1.0], **settings).y[0]


def rigid(n: int) -> sr.System:
    """A rigid pendulum with the same equation of motion."""
    c, length = G * ((n + 1) / 2 + n) / ((n + 1) / 3 + n), 0.5
    inertia = (1, 1, G * length / c - length**2)
    bar = {"position": (0, length, 0), "velocity": (length, 0, 0), "angular_velocity": (0, 0, -1)}
    rod = sr.Body("upright_0", mass=1, inertia=inertia, **bar)
    pin = sr.Revolute("pin", sr.ground, rod, point=(0, 0, 0), axis=(0, 0, 1))
    return sr.System(sr.Model("pendulum", [rod], [pin], gravity=(0, -G, 0)))


def error(n: int, run: sr.Trajectory) -> float:
    assert run.success, run.message
    angle, bar = turned(n, run.t), run["upright_0"].position
    return float(max(abs(2 * bar[:, 0] - np.sin(angle)).max(), abs(2 * bar[:, 1] - np.cos(angle)).max()))


@pytest.mark.one_in(8)
@pytest.mark.parametrize("method", [sr.Radau(), sr.ODE()])
@pytest.mark.parametrize("n", [1, 2, 10])
def test_four_bars_in_one_line(n: int, method: object) -> None:
    flat = sr.System(four_bars(n))
    coarse, fine = (
        error(n, sr.simulate(flat, until=1.5, t_eval=TIMES, method=replace(method, rtol=rtol, atol=rtol)))
        for rtol in (1e-5, 1e-8)
    )
    assert fine < 3e-6
    assert fine < 0.1 * coarse


@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", [sr.HHT(), sr.GeneralizedAlpha(), sr.HHT(stabilized=True)])
def test_methods_of_order_2_are_as_exact_as_on_a_rigid_pendulum(method: object) -> None:
    """The motion goes over the top with 1.4 % of its energy: what is lost of it at 1e-4 is too much, flat or not."""
    flat = sr.System(four_bars(2))
    for rtol in (1e-6, 1e-8):
        tight = replace(method, rtol=rtol, atol=rtol)
        one, other = (sr.simulate(s, until=10.0, method=tight) for s in (flat, rigid(2)))
        assert error(2, one) < 2 * error(2, other)
        assert abs(one["coupler_1"].euler[:, 1:]).max() < 1e-6  # a coupler turns on any other way


def test_a_run_over_such_positions_is_gone_on_with_to_the_same_bits(tmp_path: Path) -> None:
    flat, marked = system("four_bars"), []

    def stop(t: float) -> None:
        marked.append(t)
        if t > 0.75:
            raise KeyboardInterrupt

    given = {"until": 1.5, "t_eval": TIMES, "method": sr.Radau(rtol=1e-8, atol=1e-8)}
    plain = sr.simulate(flat, **given)
    cut = sr.simulate(flat, save=tmp_path / "r", progress=stop, **given)
    assert cut.status == "stopped"
    assert np.array_equal(np.asarray(sr.resume(tmp_path / "r").q), plain.q)


@pytest.mark.parametrize("times", [None, [0.5], [1.5], TIMES])
def test_a_run_that_is_carried_over_such_positions_warns(times: object) -> None:
    """Whatever states are asked for; the same run to 0.5 s passes none."""
    flat, given = sr.System(four_bars(1)), {"method": sr.Radau(rtol=1e-6, atol=1e-6)}
    passed = r"singular configuration is passed between t = 0\.\d+ and 0\.\d+ s"
    with pytest.warns(sr.SarrusWarning, match=passed):
        run = sr.simulate(flat, until=1.5, t_eval=times, **given)
    assert sum("singular configuration is passed" in one for one in run.warnings) >= 1
    with pytest.raises(sr.StrictError, match="singular configuration is passed"), sr.strict():
        sr.simulate(flat, until=1.5, t_eval=times, **given)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not sr.simulate(flat, until=0.5, t_eval=[0.5], **given).warnings


@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT(step=0.5)])
def test_states_that_are_wanted_at_such_a_position(method: object) -> None:
    """A parallelogram without forces, flat at t = 5 s: its constraints tell nothing of the way, nor of multipliers."""
    flat = linkages.chain(
        "flat", linkages.parallelogram_points(0.05), np.tile(linkages.Z, (4, 1)), np.zeros(3)
    )
    q, v = flat.q0, np.zeros(flat.nq)
    for place, share, turn in ((0, 0.5, -0.005), (7, 1.0, 0.0), (14, 0.5, -0.005)):
        v[place : place + 2] = share * 0.01 * np.array([np.sin(0.05), -np.cos(0.05)])
        v[place + 6] = turn
    run = sr.simulate(flat, sr.assemble(flat, q, v), until=20.0, method=replace(method, rtol=1e-6, atol=1e-6))
    assert run.success, run.message
    assert run.t[250] == 5.0
    assert np.allclose(run.q[250, [0, 1, 7, 8]], (0.5, 0, 2.0, 0), atol=1e-6)
    near = 1e-6 if isinstance(method, sr.Radau) else 2e-5  # HHT's is 1e-9 rad from it, where round-off counts
    assert np.allclose(run.v[250, [0, 1, 7, 8]], (0, -0.005, 0, -0.01), atol=near)
    assert np.ptp(run.kinetic_energy) < 1e-4 * run.kinetic_energy[0]
    assert np.all(np.isfinite(run.lam[:249]))
    if isinstance(method, sr.Radau):  # HHT comes there a little later
        assert np.all(np.isnan(run.lam[250]))


def test_derivatives_and_errors_of_a_run_that_ends_at_such_a_position_are_refused() -> None:
    run = sr.simulate(sr.System(four_bars(2)), until=1.0, store="steps")
    assert run.status == "singular configuration"
    for asked in (
        run.error,
        lambda name: sr.sensitivity(run, name),
        lambda name: sr.hessian(run, name, ["upright_0.mass"]),
    ):
        with pytest.raises(
            ValueError, match=r"ended near t = 0\.71\d+ s in a singular configuration, .* `until`"
        ):
            asked("upright_0.x")
