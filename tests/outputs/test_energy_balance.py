"""Stored, dissipated and supplied energies add up along whole runs, by part and in every place that takes names."""

from __future__ import annotations

import runpy
from functools import cache

import numpy as np
import pytest
from tests.examples.problems import FOLDER

import sarrus as sr
from sarrus.outputs import outputs_of

GRAVITY = (0, 0, -9.81)
FINE = {"method": sr.Radau(rtol=1e-9, atol=1e-11), "store": "dense"}


def slid() -> sr.Model:
    """A block on a slide with dry friction, a driven spring, drag in a wind, viscous drag, and stops."""
    block = sr.Body("block", mass=2.0, inertia=(0.1, 0.1, 0.1))
    guide = sr.Translational("guide", sr.ground, block, point=(0, 0, 0), axis=(1, 0, 0))
    friction = sr.DisplacementFriction(
        "friction",
        sr.ground,
        block,
        point=(0, 0, 0),
        axis=(1, 0, 0),
        load=8.0,
        mu=0.2,
        creep=0.05,
        viscous=0.3,
    )
    stop = sr.DisplacementStop(
        "stop", sr.ground, block, point=(0, 0, 0), axis=(1, 0, 0), lower=-0.2, upper=0.3, stiffness=4e3,
        exponent=1.5, damping=0.2, rounding=1e-2,
    )  # fmt: skip
    spring = sr.TSDA(
        "spring",
        sr.ground.point(-1, 0, 0),
        block.point(0, 0, 0),
        k=60.0,
        c="1+x^2",
        length=1.0,
        force="9*sin(5*t)",
    )
    drag = sr.Drag("drag", block.point(0, 0, 0), c=0.4, wind=(2.0, 0, 0))
    oil = sr.ViscousDrag("oil", block.point(0, 0, 0), c=0.2, c_turn=0.1)
    push = sr.PointForce("push", block.point(0, 0, 0), force=("3*cos(2*t)", 0.0, 0.0))
    return sr.Model("slide", [block], [guide], forces=[friction, stop, spring, drag, oil, push])


def bounced() -> sr.Model:
    """A spinning ball that falls on a plane, bounces and slides."""
    ball = sr.Body(
        "ball",
        mass=1.0,
        inertia=(0.004,) * 3,
        position=(0, 0, 0.3),
        velocity=(1, 0, 0),
        angular_velocity=(5, 0, 3),
    )
    contact = sr.SphereContact(
        "contact", ball.point(0, 0, 0), sr.ground.frame((0, 0, 0)), radius=0.1, stiffness=2e4,
        exponent=1.5, damping=0.3, mu=0.3, creep=0.02, rounding=1e-3,
    )  # fmt: skip
    return sr.Model("ball", [ball], forces=[contact], gravity=GRAVITY)


def lifted() -> sr.Model:
    """A motor that lifts an arm with a torsion spring, pin friction, a bushing-held load and an angle stop."""
    arm = sr.Body("arm", mass=2.0, inertia=(0.1, 0.1, 0.1), position=(0.5, 0, 0))
    load = sr.Body("load", mass=1.0, inertia=(0.01, 0.02, 0.03), position=(1.0, 0, 0))
    about = {"point": (0, 0, 0), "axis": (0, -1, 0)}
    pin = sr.Revolute("pin", sr.ground, arm, **about)
    motor = sr.AngleDriver("motor", "pin", "0.3*t^2")
    coil = sr.RSDA("coil", sr.ground, arm, **about, k=3.0, c=0.4, torque="2*t")
    friction = sr.AngleFriction(
        "friction", sr.ground, arm, **about, radius=0.02, load=200.0, mu=0.15, creep=0.01
    )
    stop = sr.AngleStop("stop", sr.ground, arm, **about, upper=0.2, stiffness=90.0, damping=0.1)
    K, C = np.diag([3e3, 3e3, 3e3, 40.0, 40.0, 40.0]), np.diag([9.0, 9, 9, 0.2, 0.2, 0.2])
    bush = sr.Bushing("bush", arm, load, point=(1, 0, 0), stiffness=K, damping=C, preload=(0, 0, 5, 0, 0, 0))
    forces = [coil, friction, stop, bush]
    return sr.Model("crane", [arm, load], [pin], drivers=[motor], forces=forces, gravity=GRAVITY)


def ridden() -> sr.Model:
    """A wheel on a guide over a bumpy road, and one without lift-off; a rope."""
    wheel = sr.Body("wheel", mass=20.0, inertia=(1, 1, 1), position=(0, 0, 0.32))
    other = sr.Body("other", mass=15.0, inertia=(1, 1, 1), position=(1, 0, 0.35))
    guides = [
        sr.Translational(f"guide_{body.name}", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
        for body in (wheel, other)
    ]
    tyre = sr.RoadTyre("tyre", wheel.point(0, 0, 0), k=2e4, c=100.0, radius=0.33, bump="0.05*sin(15*t)")
    plain = sr.Tyre("plain", other.point(0, 0, 0), k=2e4, c=100.0, radius=0.33)
    rope = sr.LengthStop(
        "rope",
        wheel.point(0, 0, 0),
        other.point(0, 0, 0),
        upper=1.0004,
        stiffness=1e6,
        damping=0.1,
        rounding=1e-5,
    )
    return sr.Model("ride", [wheel, other], guides, forces=[tyre, plain, rope], gravity=GRAVITY)


MODELS = {
    "slide": (slid, 3.0),
    "ball": (bounced, 0.8),
    "crane": (lifted, 1.5),
    "ride": (ridden, 0.8),
    "slider-crank": (lambda: sr.load("slider_crank"), 1.0),
}


@cache
def run(name: str) -> sr.Trajectory:
    model, until = MODELS[name]
    return sr.simulate(
        sr.System(model()), until=until, t_eval=np.linspace(0, until, 41), **(FINE | {"store": "steps"})
    )


@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", MODELS)
def test_the_balance_is_even(name: str) -> None:
    balance = run(name).energy_balance()
    size = max(np.ptp(balance.kinetic), np.ptp(balance.potential + balance.elastic))
    assert balance.drift < (3e-6 if name == "ride" else 2e-7) * size  # its rope is stiff
    assert max(np.ptp(x) for x in (*balance.dissipated.values(), *balance.supplied.values())) > 1e-2 * size
    for part, energy in balance.dissipated.items():
        assert np.all(np.diff(energy) >= -1e-9 * size), part
        assert np.array_equal(energy, run(name)[f"{part}.dissipated_energy"])
    for part, energy in balance.supplied.items():
        assert np.allclose(energy, run(name)[part].supplied_energy, rtol=1e-12, atol=1e-12 * size)
    whole = run(name)["energy"]
    assert whole.dissipated == pytest.approx(sum(balance.dissipated.values()), abs=1e-12 * size)
    assert whole.supplied == pytest.approx(sum(balance.supplied.values()), abs=1e-12 * size)
    assert whole.elastic == pytest.approx(balance.elastic)


def test_each_part_does_what_it_is_for() -> None:
    slide, crane, ride, ball = (run(name).energy_balance() for name in ("slide", "crane", "ride", "ball"))
    assert {n for n, x in slide.supplied.items() if np.any(x)} == {"spring", "drag", "push"}
    assert {n for n, x in slide.dissipated.items() if np.any(x)} == {
        "friction",
        "stop",
        "spring",
        "drag",
        "oil",
    }
    assert {n for n, x in crane.supplied.items() if np.any(x)} == {"coil", "motor"}
    assert {n for n, x in crane.dissipated.items() if np.any(x)} == {"coil", "friction", "stop", "bush"}
    assert {n for n, x in ride.supplied.items() if np.any(x)} == {"tyre"}
    assert np.ptp(ball.elastic) > 0.5
    assert ball.dissipated["contact"][-1] > 0.3
    text = crane.summary()
    assert "supplied motor" in text
    assert "drift of the total" in text


def test_the_balance_of_a_vehicle_on_a_bump() -> None:
    """Dropped by 2 cm, it drives at 5 m/s with its left wheels over a bump, which lifts them."""
    example = runpy.run_path(str(FOLDER / "hmmwv_bump.py"))
    system = sr.System(example["vehicle"]({"left": example["bump"]}))
    start = example["moved"](system, rise=0.02, speed=5.0)
    found = sr.simulate(system, start, until=2.0, t_eval=np.linspace(0, 2, 41), **FINE).energy_balance()
    size = np.ptp(found.potential + found.elastic)
    assert size > 300.0
    assert found.drift < 1e-6 * size
    lost = {name for name, energy in found.dissipated.items() if energy[-1] > 0.02 * size}
    wheels = [f"{end}_{side}" for end in ("front", "rear") for side in ("left", "right")]
    assert lost == {f"{kind}_{wheel}" for kind in ("damper", "tyre") for wheel in wheels}
    given = {name for name, energy in found.supplied.items() if abs(energy[-1]) > 1e-6 * size}
    assert given == {"tyre_front_left", "tyre_rear_left"}


def test_impacts_take_kinetic_energy() -> None:
    ball = sr.Body("ball", mass=1.0, inertia=(1, 1, 1), position=(0, 0, 1))
    system = sr.System(sr.Model("drop", [ball], gravity=GRAVITY))
    fall = sr.simulate(
        system, until=0.8, events=sr.Event("ball.z", direction=-1, reset=sr.Impact(0.5)), **FINE
    )
    balance = fall.energy_balance()
    assert balance.impacts[-1] == pytest.approx(0.75 * 9.81, rel=1e-7)
    assert balance.drift < 1e-7


def test_the_integral_does_not_depend_on_the_stored_times() -> None:
    model, until = MODELS["crane"]
    settings, name = {"until": until, "method": sr.Radau(rtol=1e-9, atol=1e-11)}, "motor.supplied_energy"
    steps = sr.simulate(sr.System(model()), **(settings | {"store": "steps"}))
    assert steps[name][-1] == pytest.approx(run("crane")[name][-1], rel=1e-8)
    many = sr.simulate(sr.System(model()), **settings, t_eval=np.linspace(0, until, 40001))
    assert many[name][-1] == pytest.approx(run("crane")[name][-1], rel=1e-8)
    few = sr.simulate(sr.System(model()), **settings, t_eval=[0.0, 1.0, until])
    with pytest.raises(
        sr.SarrusError, match=r"needs the motion between the stored times. Simulate with store='dense'"
    ):
        few[name]
    assert "motor.power [W]" in few.to_frame()


@pytest.mark.slow
def test_energies_are_responses_with_derivatives() -> None:
    """By the adjoint and forwards, and by differences of simulations."""
    wrt = ["coil.k", "friction.mu", "arm.mass"]
    names = [
        "motor.supplied_energy",
        "friction.dissipated_energy",
        "stop.dissipated_energy",
        "bush.dissipated_energy",
    ]
    stored = run("crane")
    back, forward = (sr.sensitivity(stored, names, wrt, method=way) for way in ("adjoint", "direct"))
    assert back.matrix == pytest.approx(forward.matrix, rel=1e-8, abs=1e-10)
    assert back.values == pytest.approx([stored[name][-1] for name in names], rel=1e-5)
    assert back.response_units == ("J",) * 4
    assert back.responses[0] == "final of motor.supplied_energy"
    from sarrus.model.written import with_numbers

    for k, (parameter, base) in enumerate(zip(wrt, back.at, strict=True)):
        ends = []
        for sign in (1, -1):
            moved = sr.System(with_numbers(stored.system.model, {parameter: base * (1 + sign * 1e-4)}))
            other = sr.simulate(moved, until=1.5, **FINE)
            ends.append(np.array([other[name][-1] for name in names]))
        wanted = (ends[0] - ends[1]) / (2e-4 * base)
        assert back.matrix[:, k] == pytest.approx(wanted, rel=1e-4, abs=1e-5 * abs(back.matrix[:, k]).max())


def test_where_an_energy_since_the_start_cannot_be_used() -> None:
    stored, name = run("crane"), "motor.supplied_energy"
    with pytest.raises(sr.SarrusError, match=r"an event cannot use .* depends on the motion since the start"):
        sr.simulate(stored.system, until=0.1, events=sr.Event(f"{name} - 1"))
    with pytest.raises(sr.SarrusError, match=r"known of a whole run only. Use Final"):
        sr.sensitivity(stored, sr.Maximum(name), ["arm.mass"])
    with pytest.raises(sr.SarrusError, match="depends on the motion since the start"):
        stored.output(name, rate=True)


@pytest.mark.parametrize("name", [name for name in MODELS if name != "slider-crank"])
def test_forces_at_both_ends(name: str) -> None:
    """They are opposite; about the origin their torques are, too; in body axes they have the same size."""
    one = run(name)
    for part in (*one.system.rows, *(force.name for force in one.system.model.forces)):
        known = {output.name for output in outputs_of(one.system, part)}
        for word in (word for word in ("force", "force_i", "torque_i") if f"{part}.{word}.x" in known):
            found, body = (
                np.array([one[f"{part}.{w}.{axis}"] for axis in "xyz"]) for w in (word, word + "_body")
            )
            assert np.linalg.norm(body, axis=0) == pytest.approx(np.linalg.norm(found, axis=0), abs=1e-9)
        if f"{part}.force_i.x" in known and f"{part}.force.x" in known:
            assert one[f"{part}"].force_i == pytest.approx(-one[part].force, abs=1e-9)
    if name == "crane":
        bush, axes = one["bush"], one["load"].euler
        from sarrus.euler import A

        wanted = [A(p).T @ f for p, f in zip(axes, bush.force, strict=True)]
        assert bush.force_body == pytest.approx(np.array(wanted), abs=1e-9)
        whole = bush.torque + np.cross(one["load"].position, bush.force)
        other = bush.torque_i + np.cross(one["arm"].position, bush.force_i)
        assert whole == pytest.approx(-other, abs=1e-8)
        reaction = one.reaction("pin")
        assert one["pin"].torque_i == pytest.approx(-reaction.torque, abs=1e-8)


def test_scalars_of_contacts_stops_and_friction() -> None:
    ball, ride, slide, crane = (run(name) for name in ("ball", "ride", "slide", "crane"))
    assert ball["contact"].normal_force == pytest.approx(ball["contact"].force_i[:, 2], abs=1e-9)
    across = np.linalg.norm(ball["contact"].force_i[:, :2], axis=1)
    assert ball["contact"].friction_force == pytest.approx(across, abs=1e-9)
    for one, part, word, of in (
        (ball, "contact", "depth", "rate"), (ride, "tyre", "compression", "rate"), (ride, "rope", "length", "rate"),
        (slide, "stop", "displacement.1", "rate.1"), (crane, "stop", "angle", "rate"),
    ):  # fmt: skip
        assert one.output(f"{part}.{word}", rate=True).values == pytest.approx(one[f"{part}.{of}"], abs=1e-9)
    assert slide["friction"].power == pytest.approx(
        -slide["friction.friction_force"] * slide["block.velocity.x"]
    )
    assert slide["stop"].power == pytest.approx(slide["stop.power.1"] + slide["stop.power.2"])
    assert crane["bush"].displacement.shape == (41, 3)
    assert ride["rope"].tension.max() > 1.0
