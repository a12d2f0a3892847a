"""What a part has over time is read by the name of the part: forces, joints, drivers, points; as arrays and tables."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from tests.outputs.test_every_name_everywhere import run as with_magnet
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.model.written import with_numbers


@cache
def run() -> sr.Trajectory:
    return sr.simulate(
        slider_crank(), until=0.4, t_eval=np.linspace(0, 0.4, 401), method=sr.Radau(rtol=1e-10)
    )


def lifted() -> sr.Trajectory:
    """A motor that lifts an arm."""
    arm = sr.Body("arm", mass=2.0, inertia=(0.1, 0.1, 0.1), position=(0.5, 0, 0))
    pin = sr.Revolute("pin", sr.ground, arm, point=(0, 0, 0), axis=(0, -1, 0))
    motor = sr.AngleDriver("motor", "pin", "0.3*t^2")
    system = sr.System(sr.Model("crane", [arm], [pin], drivers=[motor], gravity=(0, 0, -9.81)))
    return sr.simulate(system, until=1.0, t_eval=np.linspace(0, 1, 101), method=sr.Radau(rtol=1e-9))


def test_scalars_and_vectors_are_attributes() -> None:
    spring, pin, point = run()["spring"], run()["pin"], run()["rod(0.1, 0, 0)"]
    assert np.array_equal(spring.tension, run()["spring.tension"])
    assert np.array_equal(spring.force[:, 1], run()["spring.force.y"])
    assert pin.angle == pytest.approx(run().joint("pin").angle, abs=1e-12)
    assert pin.angle_rate == pytest.approx(run().joint("pin").rate, abs=1e-12)
    assert pin.force == pytest.approx(run().reaction("pin").force, rel=1e-9, abs=1e-9)
    assert pin.multiplier.shape == (401, 5)
    assert np.array_equal(point.position[:, 2], run()["rod(0.1, 0, 0).z"])
    assert run()["energy"].total == pytest.approx(run().total_energy, rel=1e-12)
    vectors, energies = (("force", "N"), ("torque", "N m")), (("power", "W"), ("energy", "J"))
    ends = {f"{word}{of}": unit for of in ("", "_i", "_body", "_i_body") for word, unit in vectors}
    split = {f"{word}_{of}": unit for word in ("dissipated", "supplied") for of, unit in energies}
    own = {"power": "W", "energy": "J", "length": "m", "rate": "m/s", "tension": "N"}
    assert spring.units == ends | split | own
    assert repr(spring).startswith("PartMotion('spring': force [N], torque [N m], force_i [N]")
    assert {"tension", "power"} <= {*dir(spring)}
    assert {"spring", "spring.tension", "pin.force.x"} <= {*run()._ipython_key_completions_()}


def test_parts_named_as_modes_and_poles_have_their_own_outputs() -> None:
    arm = sr.Body("mode1", mass=2.0, inertia=(0.1, 0.1, 0.1), position=(0.5, 0, 0))
    pin = sr.Revolute("pin", sr.ground, arm, point=(0, 0, 0), axis=(0, -1, 0))
    system = sr.System(sr.Model("crane", [arm], [pin], [sr.Torque("pole2", "pin", value="-3*x")]))
    found = sr.simulate(system, until=0.1, t_eval=[0, 0.1], store="steps")
    torque = found["pole2"]
    assert "frequency" not in torque.units
    assert all(len(getattr(torque, word)) == 2 for word in torque.units)
    with pytest.raises(sr.SarrusError, match=r"has no output 'mode1\.frequency'"):
        found["mode1.frequency"]
    plant = sr.linearize(system, system.q0, system.v0)
    assert plant["pole1.frequency"] == pytest.approx(np.sqrt(3 / 0.6) / (2 * np.pi))
    with pytest.raises(sr.SarrusError, match=r"has no output 'pole2\.frequency'"):
        plant["pole2.frequency"]


def test_names_that_are_not_there() -> None:
    with pytest.raises(AttributeError, match=r'spring has no .tensoin.\. Did you mean "tension"'):
        _ = run()["spring"].tensoin
    with pytest.raises(KeyError, match="slider"):
        _ = run()["slyder"]


def differences(t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Fourth-order central differences at inner times."""
    return (x[:-4] - 8 * x[1:-3] + 8 * x[3:-1] - x[4:]) / (12 * (t[1] - t[0]))


@pytest.mark.parametrize(
    ("output", "rate"),
    [
        ("pin.angle.acceleration", "pin.angle.rate"),
        ("guide.displacement.acceleration", "guide.displacement.rate"),
        ("cross.angle_i.acceleration", "cross.angle_i.rate"),
        ("rod.angular_acceleration.y", "rod.angular_velocity.y"),
        ("rod.angular_acceleration_body.z", "rod.angular_velocity_body.z"),
        ("rod.acceleration.x", "rod.velocity.x"),
    ],
)
def test_accelerations_are_rates_of_rates(output: str, rate: str) -> None:
    found, scale = run()[output][2:-2], abs(run()[output]).max()
    assert found == pytest.approx(differences(run().t, run()[rate]), abs=1e-5 * scale)
    assert scale > 0


def test_a_body_has_its_accelerations() -> None:
    rod = run()["rod"]
    for n, axis in enumerate("xyz"):
        assert rod.acceleration[:, n] == pytest.approx(run()[f"rod.acceleration.{axis}"], abs=1e-12)
        found = rod.angular_acceleration_global[:, n], rod.angular_acceleration_body[:, n]
        for one, word in zip(found, ("angular_acceleration", "angular_acceleration_body"), strict=True):
            assert one == pytest.approx(run()[f"rod.{word}.{axis}"], abs=1e-9)


def test_powers_are_rates_of_the_energies() -> None:
    """Of a spring without a damper that of its potential; of a motor that of the whole energy."""
    crane = lifted()
    t, power = crane.t, crane["motor"].power
    assert power[2:-2] == pytest.approx(differences(t, crane.total_energy), abs=1e-5 * abs(power).max())
    magnet = with_magnet()
    speed = magnet["slider"].velocity
    assert magnet["magnet"].power == pytest.approx((magnet["magnet"].force * speed).sum(axis=1), rel=1e-9)
    kinetic = run().kinetic_energy
    whole = sum(run()[name].power for name in ("spring",))
    model = run().system.model
    weight = sum(body.mass * run()[body.name].velocity @ model.gravity for body in model.bodies)
    assert (whole + weight)[2:-2] == pytest.approx(
        differences(run().t, kinetic), abs=1e-5 * abs(weight).max()
    )


def test_derivatives_of_powers_and_accelerations() -> None:
    """By the adjoint and forwards, and by differences of simulations."""
    names, at = ["pin.angle.acceleration", "spring.power", "rod.angular_acceleration.x"], 0.3
    responses = [sr.At(name, time=at) for name in names]
    settings = {"until": 0.4, "t_eval": [at], "method": sr.Radau(rtol=1e-11, atol=1e-13)}
    stored = sr.simulate(slider_crank(), store="steps", **settings)
    back, forward = (
        sr.sensitivity(stored, responses, ["spring.k", "rod.mass"], method=way)
        for way in ("adjoint", "direct")
    )
    assert back.matrix == pytest.approx(forward.matrix, rel=1e-9)
    for k, (parameter, base) in enumerate(zip(["spring.k", "rod.mass"], back.at, strict=True)):
        ends = []
        for sign in (1, -1):
            moved = sr.System(with_numbers(slider_crank().model, {parameter: base * (1 + sign * 1e-4)}))
            other = sr.simulate(moved, **settings)
            ends.append(np.array([other[name][0] for name in names]))
        wanted = (ends[0] - ends[1]) / (2e-4 * base)
        assert back.matrix[:, k] == pytest.approx(wanted, rel=1e-5, abs=1e-6)


def test_forces_of_a_stop_with_two_limits_are_added() -> None:
    """A block between two stops, the lower one compressed: each has a number, the part has their sum."""
    block = sr.Body("block", mass=1.0, inertia=(1, 1, 1), position=(0, 0, 0))
    guide = sr.Translational("guide", sr.ground, block, point=(0, 0, 0), axis=(1, 0, 0))
    ends = {"stiffness": 1e3, "lower": 0.1, "upper": 0.2}
    stop = sr.DisplacementStop("stop", sr.ground, block, point=(0, 0, 0), axis=(1, 0, 0), **ends)
    moved = sr.simulate(sr.System(sr.Model("stops", [block], [guide], [stop])), until=0.01)
    assert moved["stop.force.x"][0] == pytest.approx(100, rel=1e-9)
    assert moved["stop.force.x"] == pytest.approx(moved["stop.force.1.x"] + moved["stop.force.2.x"])
    assert moved["stop"].force_i[0] == pytest.approx([-100, 0, 0], rel=1e-9)
    assert moved["stop"].units["force"] == "N"


def test_a_torsion_spring_has_its_torque_and_the_vectors_on_both_bodies() -> None:
    """The scalar has the name; its vector on the second body is opposed to it along the axis."""
    arm = sr.Body("arm", mass=1.0, inertia=(1, 1, 1), orientation=sr.AxisAngle((0, 0.6, 0.8), 0.4))
    at = {"point": (0, 0, 0), "axis": (0, 0.6, 0.8)}
    pin, coil = (
        sr.Revolute("pin", sr.ground, arm, **at),
        sr.RSDA("coil", sr.ground, arm, k=5.0, angle=0.2, **at),
    )
    limit = sr.AngleStop("limit", sr.ground, arm, stiffness=10.0, lower=0.1, upper=0.2, **at)
    turned = sr.simulate(sr.System(sr.Model("clock", [arm], [pin], [coil, limit])), until=0.1)
    assert turned["coil.torque"] == pytest.approx(turned["coil"].torque)
    assert turned["coil.torque"][0] == pytest.approx(-1.0)
    for part, first in (("coil", 1.0), ("limit", 1.0)):
        vector = np.column_stack([turned[f"{part}.torque.{axis}"] for axis in "xyz"])
        assert vector[0] == pytest.approx(np.array([0, 0.6, 0.8]) * first)
        assert vector == pytest.approx(-turned[part].torque_i)
    assert turned["limit"].torque == pytest.approx(-turned["limit"].torque_i)


def test_tables() -> None:
    frame = run().to_frame()
    assert {"pin.angle [rad]", "ball.force.x [N]", "spring.tension [N]", "slider.velocity.x [m/s]"} <= {
        *frame.columns
    }
    assert frame.index.name == "t [s]"
    assert frame.attrs["units"]["spring.tension [N]"] == "N"
    assert np.array_equal(frame["spring.tension [N]"], run()["spring.tension"])
    data = run().to_xarray("spring.tension", "pin.angle")
    assert data["spring.tension"].attrs == {"units": "N"}
    assert data["t"].attrs == {"units": "s"}
    assert float(data["pin.angle"].sel(t=0.2)) == run()["pin.angle"][200]
    assert "ball.force.x" in run().to_xarray()
