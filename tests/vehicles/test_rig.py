"""The rig: sweeps, names, tables, virtual kingpins, partial sweeps, and messages for wrong input."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from math import atan, pi, radians, tan
from pathlib import Path

import numpy as np
import pytest
from tests.vehicles.published import RADIUS, V23, Reference, corner, metres, model, mp

import sarrus as sr
from sarrus.cli import main
from sarrus.vehicles.characteristics import CHARACTERISTICS

RACK = {"forward": "-x", "steering": "rack", "steps": 2}
WHOLE = sr.Vehicle(wheelbase=2.5, cg_height=0.55, brake_share=0.7, drive_share=1.0)


@cache
def system() -> sr.System:
    return sr.System(model(V23, rack=True))


@cache
def steered() -> sr.Suspension:
    return sr.suspension(system(), right=wheel(), steer=(-0.01, 0.01), vehicle=WHOLE, **RACK)


def wheel(**other: object) -> sr.Corner:
    return corner(V23, RADIUS["V23"], **other)


def hardpoints() -> sr.Model:
    """The same corner with hardpoints."""
    p = sr.Hardpoints({f"p_{name}": place for name, place in V23.items()}, unit="mm")
    plain = model(V23)
    bodies = {one.name: one for one in plain.bodies}
    bodies["knuckle"] = replace(bodies["knuckle"], position=p.p_centre)
    joints = []
    for one in plain.joints:
        if isinstance(one, sr.Spherical):
            ends = {side: bodies.get(getattr(one, side).name, sr.ground) for side in ("body_i", "body_j")}
            joints.append(replace(one, point=p[f"p_{one.name}"], **ends))
    ends = sr.ground.global_point(*p.p_tie_inner), bodies["knuckle"].global_point(*p.p_tie_outer)
    spring = plain.forces[0]
    at_arm = bodies["lower_arm"].global_point(*p.p_damper_arm)
    spring = replace(spring, point_i=sr.ground.global_point(*p.p_damper_body), point_j=at_arm)
    return sr.Model("corner", [*bodies.values()], [*joints, sr.Distance("tie_rod", *ends)], [spring])


def test_derivatives_by_hardpoints_of_the_wheel() -> None:
    """Of the wheel centre and the spindle as well; the pads follow the wheel centre."""
    given = sr.Corner(
        "knuckle", "p_centre", "p_spindle", 1e-3 * RADIUS["V23"], ("lower_ball", "upper_ball"), "spring"
    )
    result = sr.suspension(sr.System(hardpoints()), right=given, forward="-x", steps=2)
    names = ["p_centre.z", "p_spindle.x", "p_lower_ball.y", "p_tie_inner.z"]
    slope = result.sensitivity("ride_steer", wrt=names)
    values = result.sensitivity(["scrub_radius", "wheel_recession"], at=0.05, wrt=names)
    reference = Reference(V23, RADIUS["V23"])
    compared = [
        lambda r: r.slope("toe"), lambda r: r.values(mp.mpf(50))["scrub_radius"],
        lambda r: r.values(mp.mpf(50))["wheel_recession"],
    ]  # fmt: skip
    for name in names:
        toe, scrub, recession = reference.gradients(compared, *name.removeprefix("p_").split("."))
        assert slope[name] * 180 / pi * 1e-6 == pytest.approx(toe, rel=1e-8, abs=1e-12), name
        assert values[name][0] == pytest.approx(scrub, rel=1e-8, abs=1e-9), name
        assert values[name][1] == pytest.approx(recession, rel=1e-8, abs=1e-9), name
    every = result.rig.parameters()
    assert "p_lower_ball.z" in every
    assert not any(name.startswith(("lower_ball.point", "pad", "tie_rod")) for name in every)


def test_steering() -> None:
    """The wheel turns with the rack as by Newton's method; the wheel centre stays at its height."""
    result = steered()
    for row, y in enumerate(result.x("steer")):
        expected = Reference(V23, RADIUS["V23"], rack=mp.mpf(1e3 * y)).values(mp.mpf(0))
        assert result.curve("toe", "steer")[row] == pytest.approx(
            radians(float(expected["toe"])), rel=1e-9, abs=1e-12
        )
        assert result.curve("wheel_travel", "steer")[row] == pytest.approx(0.0, abs=1e-12)
    steer = result.at("steer_angle", 0.01, "steer")
    assert steer == result.at("toe", 0.01, "steer")  # of a right wheel
    assert result.at("turn_radius", 0.01) == pytest.approx(2.5 / abs(np.sin(steer)), rel=1e-12)
    assert result.at("turn_diameter", 0.01) == pytest.approx(5.0 / abs(np.sin(steer)), rel=1e-12)
    assert result.unit("steer") == "m"


def test_straight_ahead_radii_are_infinite_and_not_in_the_table() -> None:
    """An angle of round-off is none: neither the radius nor its slope, nor the percentage, is a number there."""
    result = both()
    for name in ("turn_radius", "turn_diameter", "ackermann_percentage"):
        assert result.at(name, 0.0, "steer") == np.inf
        assert np.isfinite(np.delete(result.curve(name, "steer"), np.argmin(abs(result.x("steer"))))).all()
        assert name not in result.table("steer")
    assert "ackermann_error" in result.table("steer")
    with pytest.raises(sr.SarrusError, match="left turn_radius in steer is infinite at 0"):
        result.sensitivity("turn_radius", sweep="steer")


def test_virtual_kingpin() -> None:
    """With the spring locked, the knuckle turns about its ball joints: values, and derivatives by the joints."""
    given, found = steered(), sr.suspension(system(), right=wheel(kingpin=None), vehicle=WHOLE, **RACK)
    names = found.names("kingpin")
    assert len(names) == 7
    for name in names:
        assert found.at(name) == pytest.approx(given.at(name), rel=1e-9), name
        wrt = ["upper_ball.point.x", "lower_ball.point.y"]
        one, other = (result.sensitivity(name, wrt=wrt).matrix for result in (found, given))
        assert one == pytest.approx(other, rel=1e-8, abs=1e-9), name
    with pytest.raises(sr.SarrusError, match=r"caster is not defined in bump. Use kingpin"):
        found.curve("caster", "bump")


def axle() -> sr.System:
    """Two mirrored corners with one rack, x forward and y to the left."""
    p = {
        side: {name: (-x, y if side == "left" else -y, z) for name, (x, y, z) in metres(V23).items()}
        for side in ("left", "right")
    }
    bodies, joints, forces, ground = [], [], [], sr.ground
    bar = sr.Body(
        "bar", 2, (0.1, 0.1, 0.1), position=(p["left"]["tie_inner"][0], 0, p["left"]["tie_inner"][2])
    )
    for side, at in p.items():
        lower, upper, knuckle = (
            sr.Body(f"{name}_{side}", 5, (0.1, 0.1, 0.1), position=at[point])
            for name, point in (("lower", "lower_ball"), ("upper", "upper_ball"), ("knuckle", "centre"))
        )
        bodies += [lower, upper, knuckle]
        for arm, name in ((lower, "lower"), (upper, "upper")):
            axis = tuple(np.subtract(at[f"{name}_rear"], at[f"{name}_front"]).tolist())
            joints.append(
                sr.Revolute(f"{name}_hinge_{side}", ground, arm, point=at[f"{name}_front"], axis=axis)
            )
            joints.append(sr.Spherical(f"{name}_ball_{side}", arm, knuckle, point=at[f"{name}_ball"]))
        rod = bar.global_point(*at["tie_inner"]), knuckle.global_point(*at["tie_outer"])
        joints.append(sr.Distance(f"tie_rod_{side}", *rod))
        ends = ground.global_point(*at["damper_body"]), lower.global_point(*at["damper_arm"])
        forces.append(sr.TSDA(f"spring_{side}", *ends, k=60e3, length=0.43))
    joints.append(sr.Translational("rack", ground, bar, point=bar.position, axis=(0, 1, 0)))
    return sr.System(sr.Model("axle", [*bodies, bar], joints, forces))


def sided(side: str) -> sr.Corner:
    sign = 1 if side == "left" else -1
    centre, spindle = ((0.0, sign * y, 0.0) for y in (0.65, 0.55187))
    return sr.Corner(f"knuckle_{side}", centre, spindle, 0.2794, (f"lower_ball_{side}", f"upper_ball_{side}"))


@cache
def both() -> sr.Suspension:
    return sr.suspension(
        axle(), sided("left"), sided("right"), steering="rack", steer=(-0.01, 0.01), steps=2, vehicle=WHOLE
    )


def test_roll() -> None:
    """Of small angles the slopes in roll are those in bump times half of the track; the roll centre is the same."""
    result, single = both(), steered()
    track = 1.3 + sum(result.at("track_change", 0.03, "roll", side) for side in result.sides)
    assert result.at("roll_angle", 0.03, "roll") == pytest.approx(
        atan(0.06 / track), abs=1e-3
    )  # right in bump
    assert result.at("wheel_travel", 0.03, "roll", "right") == pytest.approx(0.03, rel=1e-9)
    height, lateral = (result.at(f"roll_centre_{word}", sweep="roll") for word in ("height", "lateral"))
    assert height == pytest.approx(single.at("roll_centre_height"), rel=1e-9)
    assert lateral == pytest.approx(0.0, abs=1e-12)
    left, right = (result.at("roll_steer", side=side) for side in ("left", "right"))
    assert right == pytest.approx(-left, rel=1e-9)
    # A and C have the same vertical velocity, because the wheel is vertical: dz/dφ is half of the track.
    assert result.at("roll_camber", side="right") == pytest.approx(single.at("ride_camber") * 0.65, rel=1e-9)


def test_an_infinite_swing_arm_is_left_out_of_derivatives() -> None:
    """In front view the arm of a trailing arm is infinite; its curvature is tilt over length."""
    arm = sr.Body("arm", 10, (1, 1, 1), position=(-0.4, 0.6, 0))
    pivot = sr.Revolute("pivot", sr.ground, arm, point=(0, 0.5, 0), axis=(0, 1, 0))
    given = sr.Corner("arm", (-0.4, 0.7, 0), (-0.4, 0.6, 0), 0.3)
    result = sr.suspension(sr.System(sr.Model("arm", [arm], [pivot])), left=given, steps=1)
    assert result.at("fvsa_length") == np.inf
    names, wrt = (
        ["svsa_length", "fvsa_length", "fvsa_curvature", "svsa_curvature"],
        ["pivot.axis.x", "pivot.point.x"],
    )
    infinite = "arm: left fvsa_length in bump is infinite at 0. Take the derivatives of its reciprocal, fvsa_curvature."
    with pytest.warns(sr.SarrusWarning, match=re.escape(infinite)):
        gradient = result.sensitivity(names, wrt=wrt)
    assert [one.split()[1] for one in gradient.responses] == [
        "svsa_length",
        "fvsa_curvature",
        "svsa_curvature",
    ]
    assert gradient["pivot.point.x"] == pytest.approx([1.0, 0.0, -1 / 0.4**2], rel=1e-12)
    assert gradient["pivot.axis.x"][1] == pytest.approx(1 / 0.4, rel=1e-12)
    with pytest.raises(sr.SarrusError, match=re.escape(infinite)):
        result.sensitivity("fvsa_length")
    with pytest.raises(
        sr.SarrusError, match=r"slope of left fvsa_length in bump is undefined at 0\. Take its deriv"
    ):
        result.sensitivity("fvsa_length", slope=True)


def test_a_trailing_arm_without_a_kingpin() -> None:
    """It has the other characteristics: recession, and a side-view swing arm of the length of the arm."""
    arm = sr.Body("arm", 10, (1, 1, 1), position=(-0.4, 0.6, 0))
    pivot = sr.Revolute("pivot", sr.ground, arm, point=(0, 0.5, 0), axis=(0, 1, 0))
    given = sr.Corner("arm", (-0.4, 0.7, 0), (-0.4, 0.6, 0), 0.3)
    result = sr.suspension(sr.System(sr.Model("arm", [arm], [pivot])), left=given, steps=2)
    assert "caster" not in result.names()
    assert result.at("svsa_length") == pytest.approx(0.4, rel=1e-9)
    assert result["wheel_recession"][-1] == pytest.approx(np.sqrt(0.4**2 - 0.05**2) - 0.4, rel=1e-9)
    assert "camber" in str(result)
    with pytest.raises(sr.SarrusError, match=r"no sweep 'kingpin'. Give both points"):
        result.curve("caster")


def test_ackermann() -> None:
    """The ideal steering has cot δ_right - cot δ_left = track/L; the angle is that of the inner minus the outer."""
    result = both()
    for row, y in enumerate(result.x("steer")):
        left, right = (result.curve("steer_angle", "steer", side)[row] for side in ("left", "right"))
        angle = result.curve("ackermann_angle", "steer")[row]
        assert angle == pytest.approx(left - right, abs=1e-15)
        if abs(y) > 0:
            track = 1.3 + sum(result.curve("track_change", "steer", side)[row] for side in ("left", "right"))
            ideal = left - atan(1 / (1 / tan(left) + track / 2.5))
            assert result.curve("ackermann_error", "steer", "left")[row] == pytest.approx(
                angle - ideal, rel=1e-9
            )
            percentage = result.curve("ackermann_percentage", "steer", "left")[row]
            assert percentage == pytest.approx(100 * angle / ideal, rel=1e-9)
            other = atan(1 / (1 / tan(right) - track / 2.5)) - right
            assert result.curve("ackermann_error", "steer", "right")[row] == pytest.approx(
                angle - other, rel=1e-9
            )


def test_tables(tmp_path: Path) -> None:
    result = both()
    text = result.table("roll", "right")
    assert text.startswith("axle, right wheel: roll from -30 to 30 mm")
    assert "roll_centre_height" in text
    result.to_csv(tmp_path / "steer.csv", "steer")
    header, *rows = (tmp_path / "steer.csv").read_text().splitlines()
    assert header.startswith("steering [mm],left.toe [deg],right.toe [deg]")
    assert len(rows) == 5
    frame = result.to_frame()
    assert frame["left.camber [deg]"].to_numpy() == pytest.approx(np.degrees(result["camber"]), rel=1e-12)
    assert frame.index.name == "wheel travel [mm]"
    assert repr(result) == "<Suspension axle: left and right, bump, roll, steer>"
    for sweep in ("bump", "roll", "steer"):
        axes = result.plot(sweep)
        assert len(axes) > 5
    assert len(result.plot("bump", "toe", "camber")) == 2


def test_a_stroke_beyond_the_end() -> None:
    """The curves end there, with a message; what was reached has derivatives."""
    result = sr.suspension(
        system(), right=wheel(), bump=(-0.05, 0.55), steps=11, forward="-x", steering="rack"
    )
    assert not result.success
    assert result.message.startswith("bump ends at +0.")
    assert "lock" in result.message
    assert result.x()[-1] < 0.55
    assert len(result["toe"]) == len(result.x())
    last = float(result.x()[-1])
    assert np.isfinite(result.sensitivity("toe", last, wrt=["tie_rod.point_i"]).matrix).all()
    assert result.message in str(result)


def test_every_characteristic_has_a_definition() -> None:
    page = Path(__file__).parents[2].joinpath("docs", "how-to", "suspension.md").read_text(encoding="utf-8")
    for name, one in CHARACTERISTICS.items():
        assert f"`{name}`" in page, name
        assert one.of.__doc__, name


def refusal(message: str, call: Callable[[], object]) -> None:
    with pytest.raises(sr.SarrusError) as caught:
        call()
    assert message in str(caught.value)


BAD_CORNERS = {
    "no body \"knuckel\". Did you mean": {"carrier": "knuckel"},
    "radius must be greater than 0, but is -1.0. Give": {"radius": -1.0},
    "spindle is the wheel centre, so that the spin axis has no direction. Give": {"spindle": (0.0, 0.65, 0.0)},
    "does not point outboard from spindle to centre. Exchange": {"spindle": (0.0, 0.75, 0.0)},
    "centre must be three numbers, got (0.0, 1.0). Give": {"centre": (0.0, 1.0)},
    "centre names no hardpoint or joint \"hub\". Choose": {"centre": "hub"},
    "which is not on \"knuckle\". Name a joint of this body": {"centre": "lower_front"},
    "is not above the first. Give": {"kingpin": ("upper_ball", "lower_ball")},
    "spring names no force \"sprung\". Did you mean": {"spring": "sprung"},
}  # fmt: skip


@pytest.mark.parametrize("message", BAD_CORNERS)
def test_wrong_corners(message: str) -> None:
    changed = replace(wheel(), **BAD_CORNERS[message])
    refusal(message, lambda: sr.suspension(system(), right=changed, **RACK))


def test_wrong_arguments() -> None:
    refusal("there is no wheel. Give", lambda: sr.suspension(system()))
    refusal("Exchange the points or the sides", lambda: sr.suspension(system(), left=wheel(), **RACK))
    refusal("forward must be one of x, -x", lambda: sr.suspension(system(), right=wheel(), forward="north"))
    refusal("Name the bodies that stand still", lambda: sr.suspension(system(), right=wheel(), forward="-x"))
    refusal(
        "no joint steers. Name", lambda: sr.suspension(system(), right=wheel(), forward="-x", steer=(-1, 1))
    )
    refusal(
        "there is no joint coordinate",
        lambda: sr.suspension(system(), right=wheel(), forward="-x", steering="wheel"),
    )
    refusal(
        "fixed: the model has no body", lambda: sr.suspension(system(), right=wheel(), fixed=["car"], **RACK)
    )
    refusal("on both sides of 0", lambda: sr.suspension(system(), right=wheel(), bump=(0.01, 0.02), **RACK))
    refusal("steps must be", lambda: sr.suspension(system(), right=wheel(), **RACK | {"steps": 0}))


def test_wrong_names() -> None:
    result = steered()
    refusal("there is no 'tow'. Did you mean", lambda: result["tow"])
    refusal("there is no left wheel", lambda: result.curve("toe", side="left"))
    refusal("there is no sweep 'roll'. Give both wheels", lambda: result.curve("toe", "roll"))
    refusal("is not defined in bump. Use steer", lambda: result.curve("turn_radius", "bump"))
    refusal("roll_angle needs other. Give both wheels", lambda: result.curve("roll_angle"))
    refusal("damper_ratio needs damper. Name it", lambda: result["damper_ratio"])
    refusal("0.013 is no displacement of bump. Take 0.025", lambda: result.at("toe", 0.013))
    refusal("are different sweeps", lambda: result.sensitivity(["toe", "turn_radius"]))
    refusal("no rate 'spring_rate'. Did you mean", lambda: result.compliance()["spring_rate"])
    refusal("needs tyre_stiffness. Give", lambda: result.compliance()["ride_rate"])
    plain = sr.suspension(system(), right=wheel(), **RACK)
    refusal("needs wheelbase. Give it, vehicle=sr.Vehicle(wheelbase=...)", lambda: plain["anti_dive"])


def test_a_suspension_without_springs_has_no_rates() -> None:
    bare = sr.System(replace(model(V23, rack=True), forces=[]))
    result = sr.suspension(bare, right=wheel(spring=None), **RACK)
    refusal("no force carries the load of the wheels. Add a spring", result.compliance)


RIG = """
model: corner.json
wheels:
  right: {carrier: knuckle, centre: [0, 650 mm, 0], spindle: [0, 551.87 mm, 0], radius: 279.4 mm,
    kingpin: [lower_ball, upper_ball], spring: spring}
forward: -x
steering: rack
bump: [-50 mm, 50 mm]
steps: 2
vehicle: {wheelbase: 2.5 m, tyre_stiffness: 200 N/mm}
"""


def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    model(V23, rack=True).save(tmp_path / "corner.json")
    (tmp_path / "rig.yaml").write_text(RIG)
    line = "suspension rig.yaml --compliance --sensitivity ride_steer --csv curves.csv --figure sheet.png"
    assert main(line.split()) == 0
    found = capsys.readouterr().out
    assert "toe                                    0 deg    0.0283202 deg/mm" in found
    assert "wheel_rate" in found
    assert "ride_rate" in found
    assert "tie_rod.point_i.z" in found
    assert (tmp_path / "sheet.png").stat().st_size > 5000
    assert len((tmp_path / "curves.csv").read_text().splitlines()) == 6
    for change, message in {
        ("radius: 279.4 mm", "radius: 3 kg"): "must be in m",
        ("right: {", "middle: {"): "there is no side 'middle'",
        ("steps: 2", "stroke: 2"): "a rig has no key 'stroke'",
        ("carrier: knuckle, ", ""): "the key 'carrier' is missing",
        ("spring: spring", "springs: spring"): "there is no key 'springs'",
        ("bump: [-50 mm, 50 mm]", "bump: 50 mm"): "must be two displacements",
        ("model: corner.json", "name: corner"): "a rig has no key 'name'",
    }.items():
        (tmp_path / "wrong.yaml").write_text(RIG.replace(*change))
        assert main(["suspension", "wrong.yaml"]) != 0
        assert message in capsys.readouterr().err, change
