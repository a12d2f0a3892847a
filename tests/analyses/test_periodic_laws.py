"""Laws that repeat: periodic tables, `mod` and `floor`; and tables whose range a motion leaves."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import sarrus as sr
from sarrus.functions import floor, mod
from sarrus.model.written import with_numbers

TURN = 2 * np.pi
X = np.linspace(0, TURN, 9)
Y = np.array([0.3, 1.0, 0.5, -0.4, -0.9, -0.2, 0.1, 0.2, 0.3])
RISING = [[0.0, 0.0], [1.0, 2.0], [2.0, 3.0], [3.0, 5.0]]


def flywheel(value: Any, **given: Any) -> sr.System:
    """A wheel that is driven by a torque over its angle."""
    wheel = sr.Body("wheel", 1.0, (0.1, 0.1, 0.2))
    pin = sr.Revolute("pin", sr.ground, wheel, point=(0, 0, 0), axis=(0, 0, 1))
    return sr.System(sr.Model("wheel", [wheel], [pin], [sr.Torque("load", "pin", value=value, **given)]))


def slider(value: Any, **given: Any) -> sr.System:
    """A mass on a rail with a force along it."""
    mass = sr.Body("mass", 2.0, (1, 1, 1))
    rail = sr.Translational("rail", sr.ground, mass, point=(0, 0, 0), axis=(1, 0, 0))
    return sr.System(
        sr.Model("slider", [mass], [rail], [sr.Force("push", joint="rail", value=value, **given)])
    )


def angle(y: np.ndarray, until: float = 1.5, speed: float = 20.0) -> float:
    law = CubicSpline(X, y, bc_type="periodic", extrapolate="periodic")
    found = solve_ivp(
        lambda t, z: [z[1], law(z[0]) / 0.2], (0, until), [0, speed], rtol=1e-11, atol=1e-11, max_step=0.002
    )
    return float(found.y[0, -1])


def periodic_flywheel() -> sr.System:
    return flywheel(sr.Curve.table(np.transpose([X, Y]).tolist(), periodic=True), over="pin.angle")


def test_a_periodic_table_over_an_angle_goes_on_for_all_revolutions() -> None:
    system = periodic_flywheel()
    run = sr.simulate(
        system,
        sr.assemble(system, rates={"pin": 20.0}),
        until=1.5,
        store="steps",
        method=sr.Radau(rtol=1e-11),
    )
    assert run["pin.angle"][-1] > 4 * TURN
    assert run["pin.angle"][-1] == pytest.approx(angle(Y), abs=1e-7)
    law = CubicSpline(X, Y, bc_type="periodic", extrapolate="periodic")
    assert np.allclose(run["load.value"], law(run["pin.angle"]), atol=1e-10)
    found = sr.sensitivity(run, "pin.angle", ["load.value.1.y", "load.value.3.y"])
    for column, rows in enumerate(([0, -1], [2])):
        step = np.zeros(len(Y))
        step[rows] = 1e-3
        expected = (angle(Y + step) - angle(Y - step)) / 2e-3
        assert found.matrix[0, column] == pytest.approx(expected, rel=1e-5)


def test_a_periodic_table_is_written_and_read_and_takes_other_values(tmp_path: Path) -> None:
    system = periodic_flywheel()
    system.model.save(tmp_path / "wheel.yaml")
    again = sr.System(sr.load(tmp_path / "wheel.yaml"))
    assert again.b == pytest.approx(system.b)
    moved = with_numbers(system.model, {"load.value.1.y": 0.5})
    law = next(force for force in moved.forces if force.name == "load").value
    assert law.periodic
    assert law.pairs[0][1] == law.pairs[-1][1] == 0.5


@pytest.mark.parametrize("value", ["10*mod(t, 0.3) + floor(t)", lambda t: 10 * mod(t, 0.3) + floor(t)])
def test_a_load_of_mod_and_floor_is_right_over_all_its_jumps(value: Any) -> None:
    run = sr.simulate(slider(value), until=2.5)
    law = 10 * np.mod(run.t, 0.3) + np.floor(run.t)
    smooth = np.min(abs(run.t[:, None] - np.r_[np.arange(9) * 0.3, 1, 2]), axis=1) > 1e-6
    assert np.allclose(run["push.value"][smooth], law[smooth], atol=1e-12)
    # ∫ mod(t, P) dt = n P²/2 + u²/2 with t = n P + u, ∫ floor(t) dt = n (n - 1)/2 + n u
    speed = 10 * (8 * 0.045 + 0.005) + 1 + 2 * 0.5
    assert run["mass.velocity.x"][-1] == pytest.approx(speed / 2, abs=1e-9)


def test_a_spring_of_mod_of_its_length_is_passed_at_each_jump() -> None:
    mass = sr.Body("mass", 1.0, (1, 1, 1), (1.2, 0, 0), velocity=(1.0, 0, 0))
    rail = sr.Translational("rail", sr.ground, mass, point=(1.2, 0, 0), axis=(1, 0, 0))
    ends = sr.ground.point(0, 0, 0), mass.point(0, 0, 0)
    spring = sr.TSDA("spring", *ends, k="mod(x, 0.5)", length=0.0)
    run = sr.simulate(sr.System(sr.Model("stairs", [mass], [rail], [spring])), until=1.0)
    x, v = run["mass.x"], run["mass.velocity.x"]
    assert x.max() > 1.5

    def work(at: np.ndarray) -> np.ndarray:  # ∫ mod(x, 1/2) x dx from one jump to the next
        low = 0.5 * np.floor(at / 0.5)
        return (at**3 - low**3) / 3 - low * (at**2 - low**2) / 2

    whole = np.where(x >= 1.5, work(np.array(1.5 - 1e-12)), 0.0) - work(np.array(1.2)) + work(x)
    assert np.allclose(0.5 * v**2 + whole, 0.5, atol=1e-8)


@pytest.mark.parametrize("value", ["mod(pin.angle, 2)", "x*floor(x)"])
def test_a_force_that_jumps_with_the_motion_is_refused_with_what_repeats(value: str) -> None:
    with pytest.raises(sr.ModelError, match="For what repeats use a periodic table"):
        flywheel(value)


@pytest.mark.parametrize("options", [{}, {"store": "steps"}, {"store": "dense"}, {"method": sr.HHT()}])
def test_a_run_that_leaves_a_table_of_a_force_warns_once(options: dict[str, Any]) -> None:
    system = slider(RISING, over="rail.displacement")
    text = r"push: its table ends at 0 and 3, but is used at 3\.\d+ at t = 1\.\d+ s, continued by its tangent"
    with pytest.warns(sr.SarrusWarning, match=text) as found:
        run = sr.simulate(
            system, sr.assemble(system, rates={"rail": 2.0}), until=2.0, t_eval=[0, 2.0], **options
        )
    assert len(found) == len(run.warnings) == 1
    before = float(run.warnings[0].partition("at t = ")[2].partition(" s")[0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sr.simulate(system, sr.assemble(system, rates={"rail": 2.0}), until=0.5 * before)


def test_drivers_and_equilibria_that_leave_tables_warn() -> None:
    mass = sr.Body("mass", 2.0, (1, 1, 1))
    rail = sr.Translational("rail", sr.ground, mass, point=(0, 0, 0), axis=(0, 0, 1))
    motor = sr.DisplacementDriver("motor", "rail", RISING)
    driven = sr.System(sr.Model("driven", [mass], [rail], drivers=[motor]))
    for analysis in (sr.kinematics, sr.simulate):
        analysis(driven, until=3.0)
        with pytest.warns(sr.SarrusWarning, match="motor: its table ends at 0 and 3, but is used at"):
            analysis(driven, until=3.5)
    spring = sr.TSDA(
        "spring",
        sr.ground.point(0, 0, 5),
        mass.point(0, 0, 0),
        k=[[4, 9], [5, 10], [5.5, 12]],
        length=4.0,
    )
    hanging = sr.System(sr.Model("hanging", [mass], [rail], [spring], gravity=(0, 0, -9.81)))
    with pytest.warns(sr.SarrusWarning, match=r"spring: its table ends at 4 and 5\.5"):
        assert sr.equilibrium(hanging).success
