"""Drivelines against closed forms: shafts, engines, clutches with gears, converters, differentials, brakes."""

import numpy as np
import pytest

import sarrus as sr

Z = (0, 0, 1)


def wheel(name, inertia, x=0.0):
    body = sr.Body(name, mass=1.0, inertia=(inertia, inertia, inertia), position=(x, 0, 0))
    return body, sr.Revolute(f"hub_{name}", sr.ground, body, point=(x, 0, 0), axis=Z)


def system(*parts, left=2.0, right=2.0):
    bodies, joints = zip(wheel("left", left), wheel("right", right, 1.0), strict=True)
    return sr.System(sr.Model("driveline", bodies, joints, parts))


def test_engine_turns_its_shaft():
    """J ω̇ = u (a - b ω) + (1 - u) (-c ω), linear: ω = ω∞ (1 - exp(-t/τ)), and its derivatives."""
    u, a, b, c, J = 0.6, 200.0, 0.1, 0.3, 0.25
    of = system(
        sr.Shaft("crank", inertia=J, torque="engine.value"),
        sr.Engine("engine", "crank", u, [[0, a], [1000, a - 1000 * b]], f"-{c}*x"),
    )
    run = sr.simulate(of, until=1.0, store="steps")
    drag = u * b + (1 - u) * c
    end, decay = u * a / drag, np.exp(-drag / J)
    assert run["crank.rate"][-1] == pytest.approx(end * (1 - decay), rel=1e-8)
    assert run["engine.value"][-1] == pytest.approx(u * a * decay, rel=1e-7)
    found = sr.sensitivity(run, sr.Final("crank.rate"), wrt=["crank.inertia", "engine.throttle"])
    slope = a / drag - u * a * (b - c) / drag**2
    assert found["crank.inertia"] == pytest.approx(-end * decay * drag / J**2, rel=1e-6)
    assert found["engine.throttle"] == pytest.approx(
        slope * (1 - decay) + end * decay * (b - c) / J, rel=1e-6
    )


def test_closed_clutch_couples_the_inertias():
    """With a closed clutch everything turns as one: α = T n / (J_e n² + 2 J), n = gear · final ratio."""
    T, J, gear, final, inertia = 100.0, 0.2, 3.0, 4.0, 2.0
    n = gear * final
    of = system(
        sr.Shaft("crank", inertia=J, torque="engine.value - box.value"),
        sr.Engine("engine", "crank", 1.0, T),
        sr.Transmission("box", "crank", "diff", gear, 400.0, creep=0.5),
        sr.Differential("diff", "hub_left", "hub_right", final, "box.output"),
    )
    run = sr.simulate(of, until=2.0)
    alpha = T * n / (J * n * n + 2 * inertia)
    rates = run["hub_left.rate"]
    assert (rates[-1] - rates[-101]) / (run.t[-1] - run.t[-101]) == pytest.approx(alpha, rel=1e-6)
    transmitted = 2 * inertia * alpha / n
    assert run["box.value"][-1] == pytest.approx(transmitted, rel=1e-3)  # 800 N m per rad/s of slip
    slip = run["crank.rate"][-1] - gear * run["diff.rate"][-1]
    assert slip == pytest.approx(0.5 * np.arctanh(transmitted / 400), rel=1e-3)


def test_open_clutch_transmits_nothing():
    of = system(
        sr.Shaft("crank", inertia=0.2, torque="-box.value", initial=100.0),
        sr.Transmission("box", "crank", "hub_left", 3.0, 400.0, "0"),
    )
    run = sr.simulate(of, until=0.5)
    assert run["crank.rate"][-1] == pytest.approx(100.0, rel=1e-12)
    assert abs(run["hub_left.rate"]).max() < 1e-12


def test_open_differential_gives_both_shafts_the_same_torque():
    of = system(sr.Differential("diff", "hub_left", "hub_right", 4.0, 30.0), left=2.0, right=3.0)
    run = sr.simulate(of, until=0.5)
    assert run["hub_left.rate"][-1] == pytest.approx(60.0 / 2 * 0.5, rel=1e-9)
    assert run["hub_right.rate"][-1] == pytest.approx(60.0 / 3 * 0.5, rel=1e-9)
    assert run["diff.rate"][-1] == pytest.approx(4.0 * (15.0 + 10.0) / 2, rel=1e-9)


def test_torsen_has_its_bias_ratio():
    """The torques of sliding shafts have the ratio b; the faster shaft has the smaller one."""
    b = 3.0
    of = system(
        sr.Differential("diff", "hub_left", "hub_right", 4.0, 30.0, ramp=(b - 1) / (b + 1) / 2, creep=0.01),
        left=0.1,
        right=30.0,
    )
    run = sr.simulate(of, until=0.5)
    left, right = 0.1 * run["hub_left.rate"][-1], 30.0 * run["hub_right.rate"][-1]
    assert right / left == pytest.approx(b, rel=1e-3)
    assert (left + right) / 0.5 == pytest.approx(120.0, rel=1e-9)


def test_preload_alone():
    of = system(
        sr.Differential("diff", "hub_left", "hub_right", 4.0, 30.0, preload=20.0, creep=1e-3),
        left=1.0,
        right=50.0,
    )
    run = sr.simulate(of, until=0.5)
    assert 1.0 * run["hub_left.rate"][-1] / 0.5 == pytest.approx(40.0, rel=1e-3)
    assert run["diff.value"][-1] == pytest.approx(20.0, rel=1e-9)


def test_converter_at_stall():
    """The pump reaches the speed at which its torque is that of the engine; the turbine gets the stall torque."""
    T, capacity = 150.0, 2e-3
    of = system(
        sr.Shaft("crank", inertia=0.2, torque="engine.value - converter.value", initial=50.0),
        sr.Engine("engine", "crank", 1.0, T),
        sr.TorqueConverter("converter", "crank", "hub_left", capacity, "2 - x"),
        left=1e9,
    )
    run = sr.simulate(of, until=5.0)
    assert run["crank.rate"][-1] == pytest.approx(np.sqrt(T / capacity), rel=1e-6)
    assert run["converter.output"][-1] == pytest.approx(2 * T, rel=1e-5)


def test_electric_motor_has_both_limits():
    """Below the corner speed the torque, above it the power; at the corner 2^(-1/8) of either."""
    torque, power = 200.0, 40e3

    def at(rate):
        of = system(
            sr.Shaft("rotor", inertia=1.0, torque="motor.value", initial=rate),
            sr.ElectricMotor("motor", "rotor", 1.0, torque, power),
        )
        return sr.simulate(of, until=1e-6)["motor.value"][0]

    assert at(20.0) == pytest.approx(torque, rel=1e-8)
    assert at(200.0) == pytest.approx(torque * 2**-0.125, rel=1e-12)
    assert at(2000.0) == pytest.approx(power / 2000.0, rel=1e-8)


def test_brake_stops_a_wheel():
    """A constant torque above creep: ω = ω0 - T t / J; then the wheel creeps to a stop."""
    body = sr.Body("wheel", mass=1.0, inertia=(2, 2, 2), angular_velocity=(0, 0, 10.0))
    hub = sr.Revolute("hub", sr.ground, body, point=(0, 0, 0), axis=Z)
    of = sr.System(sr.Model("m", [body], [hub], [sr.Brake("brake", "hub", "25*step(t, 0, 1, 0.1, 1)")]))
    run = sr.simulate(of, until=2.0)
    middle = np.searchsorted(run.t, 0.4)
    assert run["hub.rate"][middle] == pytest.approx(10 - 12.5 * run.t[middle], rel=1e-8)
    assert abs(run["hub.rate"][-1]) < 1e-6


def test_power_of_a_driveline_is_that_of_its_torques():
    """The work of the engine is the kinetic energy, less what clutch and differential dissipate."""
    of = system(
        sr.Shaft("crank", inertia=0.2, torque="engine.value - box.value"),
        sr.Engine("engine", "crank", 1.0, 100.0),
        sr.Transmission("box", "crank", "diff", 3.0, 400.0, "0.5"),
        sr.Differential("diff", "hub_left", "hub_right", 4.0, "box.output", preload=5.0),
        left=1.0,
        right=4.0,
    )
    run = sr.simulate(of, until=1.0, t_eval=np.linspace(0, 1, 20001))
    crank, left, right = (run[f"{name}.rate"] for name in ("crank", "hub_left", "hub_right"))
    engine = np.trapezoid(run["engine.value"] * crank, run.t)
    clutch = np.trapezoid(run["box.value"] * (crank - 3 * run["diff.rate"]), run.t)
    friction = np.trapezoid(run["diff.value"] * (left - right), run.t)
    kinetic = 0.1 * crank[-1] ** 2 + 0.5 * left[-1] ** 2 + 2 * right[-1] ** 2
    assert clutch > 0.5
    assert friction > 0.1
    assert kinetic == pytest.approx(engine - clutch - friction, rel=1e-6)


def test_a_model_file(tmp_path):
    """The same parts in a file, and again in the file that is written from them."""
    text = """
name: driveline
bodies: {wheel: {mass: 1, inertia: [2, 2, 2]}}
joints: {hub: {type: revolute, bodies: [ground, wheel], point: [0, 0, 0], axis: [0, 0, 1]}}
forces:
  crank: {type: shaft, inertia: 0.2, torque: engine.value - box.value}
  engine: {type: engine, joint: crank, throttle: 0.5, full_load: {table: [[0, 100], [500, 150]]}, motoring: -0.1*x}
  box: {type: transmission, input: crank, output: hub, ratio: 3, capacity: 400 N m}
"""
    path = tmp_path / "driveline.yaml"
    path.write_text(text, encoding="utf-8")
    model = sr.load(path)
    model.save(tmp_path / "again.yaml")
    ends = [
        sr.simulate(sr.System(one), until=0.2)["hub.rate"][-1]
        for one in (model, sr.load(tmp_path / "again.yaml"))
    ]
    assert ends[0] == pytest.approx(3 * 0.5 * 100 / (0.2 * 9 + 2) * 0.2, rel=0.05)
    assert ends[0] == ends[1]


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ([sr.Brake("brake", "axle", 3.0)], 'brake": .*axle'),
        ([sr.Brake("brake", "hub_left", 3.0, creep=0.0)], "creep must be greater than 0"),
        ([sr.Shaft("crank", inertia=0.0, torque="1")], "inertia must be greater than 0"),
        ([sr.Differential("d", "hub_left", "hub_right", 4.0, "d.value")], "algebraic loop"),
        ([sr.Engine("engine", "hub_left", "pedal", 100.0)], 'throttle has the unknown name "pedal"'),
        ([sr.Transmission("box", "hub_left", "diff", 3.0, 400.0)], '"?diff'),
    ],
)
def test_wrong_drivelines(parts, message):
    with pytest.raises(sr.ModelError, match=message):
        system(*parts)


def test_outputs_with_the_name_of_a_field_are_outputs_in_files(tmp_path):
    """``box.output`` is the torque, not the shaft that the field ``output`` of the box names."""
    of = system(
        sr.Shaft("crank", inertia=0.2, torque="-box.value", initial=90.0),
        sr.Transmission("box", "crank", "axle", 3.0, 400.0, 0.9),
        sr.Differential("axle", "hub_left", "hub_right", 4.0, "box.output"),
    )
    of.model.save(tmp_path / "car.yaml")
    again = sr.System(sr.load(tmp_path / "car.yaml"))
    ends = [sr.simulate(one, until=0.1)["axle.rate"][-1] for one in (of, again)]
    assert ends[0] == pytest.approx(ends[1], rel=1e-12)
    assert abs(ends[0]) > 1e-3


OUT_OF_RANGE = {
    "throttle": (lambda: sr.Engine("part", "hub_left", 1.5, 100.0), "throttle must not exceed 1, but is 1.5"),
    "command": (
        lambda: sr.ElectricMotor("part", "hub_left", -2.0, 9.0, 9.0),
        "command must not be less than -1",
    ),
    "engagement": (
        lambda: sr.Transmission("part", "hub_left", "hub_right", 3.0, 9.0, -0.1),
        "engagement must not be less than 0, but is -0.1",
    ),
    "no ratio": (lambda: sr.Transmission("part", "hub_left", "hub_right", 0.0, 9.0), "ratio must not be 0"),
    "one shaft": (
        lambda: sr.Transmission("part", "hub_left", "hub_left", 3.0, 9.0),
        'input and output are both "hub_left". Name two different shafts',
    ),
    "one side": (
        lambda: sr.Differential("part", "hub_left", "hub_left", 3.0, 9.0),
        'left and right are both "hub_left"',
    ),
    "no final ratio": (
        lambda: sr.Differential("part", "hub_left", "hub_right", 0.0, 9.0),
        "ratio must not be 0",
    ),
    "capacity": (
        lambda: sr.TorqueConverter("part", "hub_left", "hub_right", -1.0, 2.0),
        "capacity must not be less than 0, but is -1",
    ),
    "brake": (
        lambda: sr.Brake("part", "hub_left", -5.0),
        "torque must not be less than 0, but is -5. Correct it.",
    ),
}


@pytest.mark.parametrize("name", OUT_OF_RANGE)
def test_numbers_out_of_range_are_refused(name):
    part, message = OUT_OF_RANGE[name]
    with pytest.raises(sr.ModelError, match=f'"part": {message}'):
        system(part())


def with_parts(*parts: sr.model.Force) -> sr.System:
    wheel = sr.Body("wheel", mass=20.0, inertia=(1, 1, 1), position=(0, 0, 0.3))
    numbers = {"radius": 0.25, "k": 2e5, "c_kappa": 8e4, "c_alpha": 8e4, "mu": 0.9}
    tyre = sr.BrushTyre("tyre", wheel.point(0, 0, 0), **numbers)
    return sr.System(sr.Model("parts", [wheel], [], [tyre, *parts]))


def crank(torque: str = "engine.value") -> sr.Shaft:
    return sr.Shaft("crank", inertia=0.1, torque=torque)


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ((sr.Brake("brake", "tyre", 50.0),), 'force "brake": joint is the tyre "tyre", whose spin is no state. Give'),
        ((sr.Brake("brake", "hub", 50.0),), 'or a part with a rate, but is "hub"'),
        ((sr.Differential("diff", "crank", "right", 4.0, 1.0), crank("diff.left")), "right must name a joint that"),
        (
            (crank(), sr.Engine("engine", "crank", "pedal.x", 100.0)),
            'engine.throttle has the unknown name "pedal.x"',
        ),
        (
            (crank("gear.value"), sr.Shaft("out", inertia=1.0, torque="gear.output"),
             sr.Transmission("gear", "crank", "out", 3.0, 100.0, creep=0.0)),
            'force "gear": creep must be greater than 0, but is 0.0. Give a small speed in rad/s.',
        ),
    ],
)  # fmt: skip
def test_messages_name_the_part_and_the_field(parts: tuple[sr.model.Force, ...], message: str) -> None:
    with pytest.raises(sr.ModelError) as error:
        with_parts(*parts)
    assert message in str(error.value)


def test_a_part_that_acts_on_nothing_is_reported() -> None:
    engine = sr.Engine("engine", "crank", 1.0, 100.0)
    with pytest.warns(
        sr.SarrusWarning, match="engine does not act on crank, whose torque has no output of it. Add"
    ):
        with_parts(crank("3.0"), engine)
    run = sr.simulate(with_parts(crank("engine.value - 20"), engine), until=1.0, t_eval=[1.0])
    assert run["crank.torque"][-1] == pytest.approx(80.0)
    assert run["crank.rate"][-1] == pytest.approx(800.0)
