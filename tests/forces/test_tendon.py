"""Tendons: against forces between two points, and against the power of a rope over pulleys."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import sarrus as sr


def arm(*forces: sr.Force) -> sr.System:
    """Two links, swinging from the ground, with forces."""
    upper = sr.Body("upper", 1.0, (0.1, 0.2, 0.3), (0.3, 0, 0))
    lower = sr.Body("lower", 2.0, (0.1, 0.2, 0.3), (0.9, 0, 0))
    hip = sr.Revolute("hip", sr.ground, upper, point=(0, 0, 0), axis=(0, 1, 0))
    knee = sr.Revolute("knee", upper, lower, point=(0.6, 0, 0), axis=(0, 1, 0))
    return sr.System(sr.Model("arm", [upper, lower], [hip, knee], forces, gravity=(0, 0, -9.81)))


BODIES = arm().model.bodies
VALUE = {"value": "-k*(x - 0.7) - 0.3*v", "parameters": {"k": 5.0}}
ENDS = sr.ground.point(0.1, 0, 0.4), BODIES[1].point(0.2, 0, 0.1)
VIA = BODIES[0].point(-0.1, 0, 0.2), BODIES[0].point(0.1, 0, 0.3)
TENDONS = {
    "two points": (sr.Tendon("t", ENDS, **VALUE), {}),
    "pulleys": (sr.Tendon("t", [ENDS[0], *VIA, ENDS[1]], factors=[1, 2, 0.5], **VALUE), {}),
    "gap": (sr.Tendon("t", [ENDS[0], VIA[0], VIA[1], ENDS[1]], factors=[1, 0, 0.5], **VALUE), {}),
    "joints": (sr.Tendon("t", joints={"hip": 0.5, "knee.angle": -1.5}, **VALUE), {}),
    "around": (
        sr.Tendon("t", ENDS, around=[sr.Wrap(BODIES[0].point(0.3, 0, 0.2), 0.12, axis=(0, 1, 0.2))], **VALUE),
        {},
    ),
    "side": (
        sr.Tendon(
            "t", ENDS, around=[sr.Wrap(BODIES[0].point(0.3, 0, 0), 0.12, (0, 1, 0), (0.3, 0, -0.3))], **VALUE
        ),
        {},
    ),
    "moving": (
        sr.Tendon(
            "t",
            ENDS,
            around=[sr.Wrap(BODIES[0].point(0.3, 0, 0), 0.12, side=BODIES[1].point(-0.3, 0, -0.3))],
            **VALUE,
        ),
        {},
    ),
    "through": (
        sr.Tendon(
            "t", ENDS, around=[sr.Wrap(BODIES[0].point(0.3, 0, -0.2), 0.1, side=(0.3, 0.01, -0.2))], **VALUE
        ),
        {},
    ),
}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", TENDONS)
def test_a_tendon_does_work_along_its_length(name: str) -> None:
    """Its power is F ẋ, with the rate of the length by its differences, on a motion whose energy is balanced."""
    run = sr.simulate(
        arm(TENDONS[name][0]), until=0.4, t_eval=np.linspace(0, 0.4, 4001), method=sr.Radau(rtol=1e-9)
    )
    length, rate, value = run["t.length"], run["t.rate"], run["t.value"]
    assert np.ptp(length) > 0.1
    np.testing.assert_allclose((length[2:] - length[:-2]) / 2e-4, rate[1:-1], atol=1e-5)
    np.testing.assert_allclose(value, -5 * (length - 0.7) - 0.3 * rate, atol=1e-10)
    np.testing.assert_allclose(run["t.power"], value * rate, atol=1e-9)


def test_a_tendon_of_two_points_is_a_force_between_them() -> None:
    runs = [
        sr.simulate(arm(one), until=0.5) for one in (TENDONS["two points"][0], sr.Force("t", *ENDS, **VALUE))
    ]
    np.testing.assert_allclose(runs[0].q[-1], runs[1].q[-1], rtol=0, atol=1e-9)


@pytest.mark.one_in(8)
@pytest.mark.parametrize(
    "name",
    [
        "joints",
        *(
            pytest.param(one, marks=pytest.mark.slow)
            for one in ("pulleys", "around", "side", "moving", "through")
        ),
    ],
)
def test_derivatives(name: str) -> None:
    assert arm(TENDONS[name][0]).check_derivatives()


def test_a_rope_around_a_wheel_turns_it_by_its_radius_over_its_length() -> None:
    """Both ends leave a fixed wheel tangentially: the length is that of two tangents and an arc."""
    weight = sr.Body("weight", 1.0, (0.1, 0.1, 0.1), (0.2, 0, -1))
    guide = sr.Translational("guide", sr.ground, weight, point=(0.2, 0, 0), axis=(0, 0, 1))
    wheel = sr.Wrap(sr.ground.point(0, 5, 0), 0.2, axis=(0, 1, 0), side=(0, 0, 1))
    rope = sr.Tendon(
        "rope", [sr.ground.point(-0.2, 0, -1.5), weight.point(0, 0, 0)], around=[wheel], value="-50*(x - 3)"
    )
    model = sr.Model("hoist", [weight], [guide], [rope], gravity=(0, 0, -9.81))
    run = sr.simulate(sr.System(model), until=0.3)
    z = run["weight.z"]
    np.testing.assert_allclose(run["rope.length"], 1.5 + 0.2 * np.pi - z, atol=1e-12)
    np.testing.assert_allclose(run["rope.rate"], -run["weight.velocity.z"], atol=1e-12)
    assert np.ptp(z) > 0.01


def test_a_rope_between_opposite_points_of_a_wheel() -> None:
    """It pulls along the tangent on the given side, and its run goes on."""
    weight = sr.Body("weight", 1.0, (0.1, 0.1, 0.1))
    wheel = sr.Wrap(sr.ground.point(0, 0, 0.3), 0.1, axis=(0, 1, 0), side=(0.2, 0, 0.3))
    points = [sr.ground.point(0, 0, 0.5), weight.point(0, 0, 0.05)]
    rope = sr.Tendon("rope", points, around=[wheel], value="-100")
    run = sr.simulate(sr.System(sr.Model("swing", [weight], forces=[rope])), until=0.02)
    assert run.success, run.message
    sine = 0.1 / 0.25
    np.testing.assert_allclose(run.a[0, :3], [100 * sine, 0, 100 * np.sqrt(1 - sine**2)], atol=1e-9)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", ["two points", "joints", "pulleys", "around"])
def test_the_inertia_of_a_tendon_has_kinetic_energy(name: str) -> None:
    """½ m ẋ² + the energies of bodies and spring are constant."""
    tendon = replace(TENDONS[name][0], value="-5*(x - 0.7)", inertia=3.0, parameters={})
    run = sr.simulate(arm(tendon), until=0.5, method=sr.Radau(rtol=1e-9))
    share = 1.5 * run["t.rate"] ** 2
    assert np.ptp(share) > 0.01
    spring = 2.5 * (run["t.length"] - 0.7) ** 2
    np.testing.assert_allclose(run["energy.total"] + spring, (run["energy.total"] + spring)[0], atol=1e-6)


@pytest.mark.slow
def test_derivatives_by_the_radius_of_a_shape() -> None:
    """Against differences of whole runs."""

    def system(radius: float) -> sr.System:
        wrap = sr.Wrap(BODIES[0].point(0.3, 0, 0.2), radius, axis=(0, 1, 0.2))
        return arm(sr.Tendon("t", ENDS, around=[wrap], **VALUE))

    runs = [
        sr.simulate(system(0.12 + step), until=0.3, method=sr.Radau(rtol=1e-10), store="steps")
        for step in (0, 1e-5, -1e-5)
    ]
    found = sr.sensitivity(runs[0], sr.Final("lower.z"), wrt=["t.around.1.radius"])
    expected = (runs[1]["lower.z"][-1] - runs[2]["lower.z"][-1]) / 2e-5
    assert found["t.around.1.radius"] == pytest.approx(expected, rel=1e-4)


def test_shapes_of_tendons_in_a_model_file(tmp_path: Path) -> None:
    system = arm(TENDONS["side"][0])
    system.model.save(tmp_path / "arm.yaml")
    again = sr.System(sr.load(tmp_path / "arm.yaml"))
    np.testing.assert_allclose(again.b, system.b, rtol=1e-12)
    assert "side: [0.3, 0, -0.3]" in (tmp_path / "arm.yaml").read_text().replace(".0,", ",")


def test_a_side_of_another_body_in_a_model_file(tmp_path: Path) -> None:
    system = arm(TENDONS["moving"][0])
    system.model.save(tmp_path / "arm.yaml")
    again = sr.System(sr.load(tmp_path / "arm.yaml"))
    np.testing.assert_allclose(again.b, system.b, rtol=1e-12)


WHEEL = sr.Wrap(BODIES[0].point(0, 0, 0), 0.1)
SAME = sr.ground.point(0.9, 0, 0), BODIES[1].point(0, 0, 0)
AXIAL = replace(WHEEL, axis=(0, 0, 1), side=(0, 0, 0.5))
OTHERS = replace(AXIAL, axis=(1, 0, 0), side=BODIES[1].point(0, 0, 0))
MISTAKES = {
    "too many shapes": (sr.Tendon("t", ENDS, around=[WHEEL, None], value=1), "around must have 1 entries"),
    "no shape": (sr.Tendon("t", ENDS, around=[0.1], value=1), "around has 0.1"),
    "one shape": (sr.Tendon("t", ENDS, around=WHEEL, value=1), "around must be a list, but is Wrap"),
    "one factor": (sr.Tendon("t", ENDS, factors=2.0, value=1), r"factors must be a list, but is 2\.0"),
    "one point": (sr.Tendon("t", ENDS[0], value=1), "points must be a list, but is Point"),
    "factors of joints": (sr.Tendon("t", joints={"hip": 1.0}, factors=[2.0], value=1), "belong to points"),
    "shapes of joints": (sr.Tendon("t", joints={"hip": 1.0}, around=[WHEEL], value=1), "belong to points"),
    "coincident ends": (sr.Tendon("t", SAME, around=[WHEEL], value=1), "has zero length"),
    "side on the axis": (sr.Tendon("t", ENDS, around=[AXIAL], value=1), "around.side is on the axis"),
    "side of another body": (sr.Tendon("t", ENDS, around=[OTHERS], value=1), "around.side is on the axis"),
    "no center": (
        sr.Tendon("t", ENDS, around=[sr.Wrap((0, 0, 0), 0.1)], value=1),
        "around.center has",
    ),
    "a body as center": (
        sr.Tendon("t", ENDS, around=[sr.Wrap(sr.ground, 0.1)], value=1),
        "around.center has Ground",
    ),
    "no radius": (
        sr.Tendon("t", ENDS, around=[sr.Wrap(BODIES[0].point(0, 0, 0), 0)], value=1),
        "radius must be greater than 0",
    ),
    "no inertia": (sr.Tendon("t", ENDS, inertia=-1), "inertia must not be negative"),
    "both": (sr.Tendon("t", ENDS, joints={"hip": 1.0}, value=1), "must have points or joints"),
    "neither": (sr.Tendon("t", value=1), "must have points or joints"),
    "factors": (sr.Tendon("t", ENDS, factors=[1, 2], value=1), "one factor less than points"),
    "one body": (sr.Tendon("t", VIA, value=1), "no segment of it can move"),
    "no value": (sr.Tendon("t", ENDS), "value is missing"),
    "no point": (sr.Tendon("t", [ENDS[0], "upper"], value=1), 'points has "upper"'),
    "no joint": (sr.Tendon("t", joints={"hup": 1.0}, value=1), "there is no joint"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_mistakes(name: str) -> None:
    tendon, words = MISTAKES[name]
    with pytest.raises(sr.ModelError, match=words):
        arm(tendon)


@pytest.mark.parametrize("axis", [(0, 0, 1), None])
def test_a_rope_with_both_ends_on_the_ground_carries_a_pulley_block(axis: tuple[float, ...] | None) -> None:
    wheel = sr.Body("wheel", 1.0, (0.01, 0.01, 0.01), (0, -1, 0))
    guide = sr.Translational("guide", sr.ground, wheel, point=(0, -1, 0), axis=(0, 1, 0))
    around = sr.Wrap(wheel.point(0, 0, 0), radius=0.1, axis=axis, side=wheel.point(0, -0.3, 0))
    ends = [sr.ground.point(-0.15, 0, 0), sr.ground.point(0.15, 0, 0)]
    rope = sr.Tendon("rope", ends, around=[around], value="-k*(x - 2.31)", parameters={"k": 1e3})
    system = sr.System(sr.Model("block", [wheel], [guide], [rope], gravity=(0, -9.81, 0)))
    run = sr.simulate(system, until=0.2, method=sr.Radau(rtol=1e-10), store="steps")

    def length(y: np.ndarray) -> np.ndarray:
        away = np.hypot(0.15, y)
        arc = 2 * (1.5 * np.pi - np.arctan2(-y, -0.15) - np.arccos(0.1 / away))
        return np.asarray(2 * np.sqrt(away**2 - 0.01) + 0.1 * arc)

    def rate(t: float, y: np.ndarray, k: float) -> list[float]:
        slope = (length(y[0] + 1e-6) - length(y[0] - 1e-6)) / 2e-6
        return [y[1], -9.81 - k * (length(y[0]) - 2.31) * slope]

    def last(k: float) -> float:
        return float(solve_ivp(rate, (0, 0.2), [-1.0, 0.0], args=(k,), rtol=1e-11, atol=1e-13).y[0, -1])

    assert np.allclose(run["rope.length"], length(run["wheel.y"]), rtol=1e-12)
    assert run["wheel.y"][-1] == pytest.approx(last(1e3), abs=1e-8)
    slope = sr.sensitivity(run, "wheel.y", ["rope.parameters.k"]).matrix[0, 0]
    assert slope == pytest.approx((last(1e3 + 1) - last(1e3 - 1)) / 2, rel=1e-4)
