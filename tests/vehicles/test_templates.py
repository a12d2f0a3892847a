"""The shipped suspensions: instant axes, rods and arms by hand, and files that users change."""

from functools import cache
from math import asin, atan2
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus import mechanisms
from sarrus.algebra import Array
from sarrus.cli import main
from sarrus.euler import A
from sarrus.studies.suspension import read_suspension_file

NAMES = mechanisms.suspensions()


def analysed(name: str, **moved: Any) -> sr.Suspension:
    """A template on its rig, with hardpoints moved to other places [m]."""
    new = {f"{key}.{axis}": x for key, place in moved.items() for axis, x in zip("xyz", place, strict=True)}
    return read_suspension_file(name, lambda file: sr.load(file).with_parameters(new)).analysed()


@cache
def plain(name: str) -> sr.Suspension:
    return analysed(name)


def points(result: sr.Suspension) -> dict[str, Array]:
    table = result.rig.system.model.hardpoints
    return {name: np.array([float(x) for x in table[name]]) for name in table}


def contact(p: dict[str, Array], result: sr.Suspension, side: int = 1) -> Array:
    """The contact point of a wheel without camber."""
    placed = next(iter(result.rig.corners.values()))
    return p["wheel"] * (1, side, 1) - (0, 0, placed.corner.radius)


def row(link: Array, at: Array) -> Array:
    """The velocity of a point along a direction, by the velocity of the origin and the angular velocity."""
    return np.concatenate([link, np.cross(at, link)])


def rod(p: dict[str, Array], inner: str, outer: str) -> Array:
    return row(p[outer] - p[inner], p[outer])


def at(twist: Array, point: Array) -> Array:
    return np.asarray(twist[:3] + np.cross(twist[3:], point))


UP, AHEAD, LEFT = np.eye(3)[[2, 0, 1]]


def compare(result: sr.Suspension, twist: Array) -> None:
    """Slopes in bump of the left wheel with those of a motion that raises the wheel centre by 1."""
    p = points(result)
    a = at(twist, contact(p, result))
    spin = np.cross(twist[3:], LEFT)
    expected = {
        "toe": spin[0], "camber": -spin[2], "wheel_recession": -at(twist, p["wheel"])[0], "wheel_travel": 1.0,
    }  # fmt: skip
    for name, value in expected.items():
        assert result.at(name, slope=True, side="left") == pytest.approx(value, rel=1e-9, abs=1e-12), name
    half = p["wheel"][1]
    values = {"fvsa_angle": np.arctan(a[1] / a[2]), "svsa_angle": np.arctan(-a[0] / a[2])}
    values["roll_centre_height"] = half * a[1] / a[2]
    for name, value in values.items():
        assert result.at(name, side="left") == pytest.approx(value, rel=1e-9), name


def test_five_links_leave_one_motion() -> None:
    """The velocity of the knuckle by six linear equations: five links, and the travel of the wheel."""
    found = plain("multi_link")
    p = points(found)
    links = "upper_front", "upper_rear", "lower_front", "lower_rear", "toe"
    rows = np.array([rod(p, f"{one}_body", f"{one}_knuckle") for one in links])
    assert np.linalg.matrix_rank(rows) == 5
    assert len(found.rig.system.model.joints) == 10
    twist = np.linalg.solve(np.array([*rows, row(UP, p["wheel"])]), np.eye(6)[5])
    compare(found, twist)
    spring = at(twist, p["spring_seat"]) @ (p["spring_seat"] - p["spring_top"])
    length = np.linalg.norm(p["spring_seat"] - p["spring_top"])
    assert found.at("spring_ratio") == pytest.approx(spring / length, rel=1e-9)


PLANES = {  # a point, and the normal of the plane: of three points of an arm, or across a strut
    "double_wishbone": (("lower_front", "lower_rear", "lower_ball"), ("upper_front", "upper_rear", "upper_ball")),
    "macpherson": (("arm_front", "arm_rear", "ball"), ("strut_top", "strut_bottom")),
}  # fmt: skip


@pytest.mark.parametrize("name", PLANES)
def test_the_instant_axis_is_the_intersection_of_two_planes(name: str) -> None:
    """The wheel turns about it if the tie rod points to it."""
    p = points(plain(name))
    first, second = (_plane(p, names) for names in PLANES[name])
    axis = np.cross(first[1], second[1])
    rows = np.array([first[1], second[1], axis])
    origin = np.linalg.solve(rows, [first[1] @ first[0], second[1] @ second[0], 0.0])
    inner = p["tie_outer"] + 0.2 * (origin - p["tie_outer"])
    found = analysed(name, tie_inner=inner)
    twist = np.concatenate([np.cross(origin, axis), axis])
    compare(found, twist / at(twist, p["wheel"])[2])


def _plane(p: dict[str, Array], names: tuple[str, ...]) -> tuple[Array, Array]:
    a, b, *c = (p[one] for one in names)
    return (a, np.cross(b - a, c[0] - a)) if c else (a, b - a)


def test_the_steering_axis_of_a_strut_passes_its_top_mount() -> None:
    """Over the stroke, on both sides; the lower ball joint is a point of the arm."""
    found = plain("macpherson")
    p = points(found)
    run = found.sweeps["bump"].run
    system = found.rig.system
    for side, sign in (("left", 1), ("right", -1)):
        arm = next(one for one in run.system.model.bodies if one.name == f"arm_{side}")
        columns = run.system.coordinates_of(arm.name)
        design = system.q0[system.coordinates_of(arm.name)]
        local = A(design[3:]).T @ (p["ball"] * (1, sign, 1) - design[:3])
        for q, caster, inclination in zip(
            run.q[:, columns],
            found.curve("caster", side=side),
            found.curve("kingpin_inclination", side=side),
            strict=True,
        ):
            k = p["strut_top"] * (1, sign, 1) - q[:3] - A(q[3:]) @ local
            assert caster == pytest.approx(atan2(-k[0], k[2]), abs=1e-9)
            assert inclination == pytest.approx(atan2(-sign * k[1], k[2]), abs=1e-9)


def test_a_solid_axle_in_bump_and_roll() -> None:
    """It remains upright in bump. Its roll follows from four links and both wheels."""
    found = plain("solid_axle")
    for name in ("toe", "camber"):
        assert found[name] == pytest.approx(0.0, abs=1e-12), name
    p = points(found)
    p |= {f"{name}_right": place * (1, -1, 1) for name, place in p.items()}
    links = [("lower_body", "lower_axle"), ("lower_body_right", "lower_axle_right")]
    links += [("upper_body", "upper_axle"), ("panhard_body", "panhard_axle")]
    rows = [*(rod(p, *link) for link in links), row(UP, p["wheel"]), row(UP, p["wheel_right"])]
    twist = np.linalg.solve(np.array(rows), [0, 0, 0, 0, -1, 1])
    a, b = (at(twist, contact(p, found, side)) for side in (1, -1))
    normals = np.array([a[1:], b[1:]])
    sides = [velocity @ (0, side * p["wheel"][1], 0) for velocity, side in ((a, 1), (b, -1))]
    assert found.at("roll_centre_height", sweep="roll") == pytest.approx(
        np.linalg.solve(normals, sides)[1], rel=1e-9
    )
    assert found.at("roll_steer", side="left") == pytest.approx(
        np.cross(twist[3:], LEFT)[0] / abs(twist[3]), rel=1e-9
    )


def test_the_roll_centre_of_a_level_panhard_rod_is_at_its_height() -> None:
    p = points(plain("solid_axle"))
    level = {"panhard_axle": (*p["panhard_axle"][:2], 0.33), "panhard_body": (*p["panhard_body"][:2], 0.33)}
    found = analysed("solid_axle", lower_body=(*p["lower_body"][:2], p["lower_axle"][2]), **level)
    assert found.at("roll_centre_height", sweep="roll") == pytest.approx(0.33, rel=1e-9)
    assert found.at("roll_steer") == pytest.approx(0.0, abs=1e-12)


def test_a_trailing_arm_turns_about_its_pivot() -> None:
    """No toe and no camber; the wheel centre on a circle; of one wheel, a roll centre on the road."""
    found = plain("trailing_arm")
    p = points(found)
    for name in ("toe", "camber", "track_change"):
        assert found[name] == pytest.approx(0.0, abs=1e-12), name
    x, z = (p["pivot_inner"] - p["wheel"])[[0, 2]]
    expected = np.sqrt(x**2 + z**2 - (z - found.x()) ** 2)
    assert found["wheel_recession"] == pytest.approx(expected - x, abs=1e-12)
    one = sr.Corner("arm", "wheel", "spindle", 0.3)
    alone = sr.suspension(found.rig.system, left=one, fixed=["arm_right"])
    assert alone.at("roll_centre_height") == pytest.approx(0.0, abs=1e-12)


def test_a_semi_trailing_arm_turns_about_an_oblique_pivot() -> None:
    """Toe and camber by Rodrigues' formula, with the angle at which the wheel has its travel."""
    inner, outer = np.array([0.34, 0.3, 0.29]), np.array([0.42, 0.6, 0.32])
    found = analysed("trailing_arm", pivot_inner=inner, pivot_outer=outer)
    wheel = points(found)["wheel"]
    u = (outer - inner) / np.linalg.norm(outer - inner)

    def turned(vector: Array, angle: float) -> Array:
        c, s = np.cos(angle), np.sin(angle)
        return np.asarray(c * vector + s * np.cross(u, vector) + (1 - c) * (u @ vector) * u)

    r = wheel - inner
    a, b, c = (r - (u @ r) * u)[2], np.cross(u, r)[2], (u @ r) * u[2]
    for travel, toe, camber in zip(found.x(), found["toe"], found["camber"], strict=True):
        z = r[2] + travel - c  # a cos φ + b sin φ = z, the small angle of both
        angle = asin(z / np.hypot(a, b)) - atan2(a, b)
        angle = angle if abs(angle) < 1 else np.pi - asin(z / np.hypot(a, b)) - atan2(a, b)
        assert turned(r, angle)[2] == pytest.approx(r[2] + travel, abs=1e-12)
        s = turned(LEFT, angle)
        assert toe == pytest.approx(-atan2(-s[0], s[1]), abs=1e-9)
        assert camber == pytest.approx(asin(-s[2]), abs=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_they_reach_their_strokes(name: str) -> None:
    """The wheel rate is that of the spring by its ratio, but for the change of the ratio under load."""
    found = plain(name)
    assert found.success
    stiff = next(one for one in found.rig.system.model.forces if one.name == "spring_left")
    assert 0.5 < -found.at("spring_ratio") < 1
    assert 0.9 < found.compliance()["wheel_rate"] / (float(stiff.k) * found.at("spring_ratio") ** 2) < 1.2


@pytest.mark.parametrize("name", sorted({*NAMES} - {"solid_axle"}))  # whose Panhard rod is on one side
def test_both_sides_are_mirror_images(name: str) -> None:
    """One corner describes both wheels: curves, and derivatives by hardpoints that both sides have."""
    found = plain(name)
    for one in found.names():
        if not one.startswith(("roll_centre", "steer")):
            left, right = (found.curve(one, side=side) for side in ("left", "right"))
            assert left == pytest.approx(right, rel=1e-6, abs=1e-9), one
    rates = [
        found.sensitivity("track_change", 0.05, side=side, wrt=["wheel.z", "wheel.x", "spindle.z"]).matrix
        for side in ("left", "right")
    ]
    assert rates[0] == pytest.approx(rates[1], rel=1e-8, abs=1e-12)
    wheel, h = points(found)["wheel"], 1e-6
    moved = [analysed(name, wheel=wheel + (0, 0, step)) for step in (h, -h)]
    ends = [one.at("track_change", 0.05, side="right") for one in moved]
    assert rates[1][0, 0] == pytest.approx((ends[0] - ends[1]) / (2 * h), abs=1e-8)


def test_percentages_and_hardpoints_have_units(tmp_path: Path) -> None:
    found = plain("double_wishbone")
    assert "%/mm" in next(line for line in found.table().splitlines() if "anti_dive" in line)
    gradient = found.sensitivity("anti_dive", wrt=["upper_ball.z"])
    assert gradient.unit("upper_ball.z") == "%/m"
    assert "%/mm" in gradient.table()
    found.to_csv(tmp_path / "steer.csv", "steer")
    assert "left.ackermann_percentage [%]" in (tmp_path / "steer.csv").read_text()
    soft = found.compliance().sensitivity("wheel_rate", wrt=["spring_arm.y"])
    assert f"{soft['spring_arm.y'] / 1000:+.7g} N/(m mm)" in soft.table()


@pytest.mark.parametrize("name", NAMES)
def test_command(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By name, and as a copy with other hardpoints."""
    assert main(["suspension", name, "--sensitivity", "camber", "--at", "0.05"]) == 0
    shown = capsys.readouterr().out
    assert "spring_ratio" in shown
    assert "wheel.z" in shown
    own = tmp_path / "own.yaml"
    own.write_text(mechanisms.path(name).read_text().replace("wheel: [0, 7", "wheel: [0, 8"))
    assert main(["suspension", str(own)]) == 0
    assert capsys.readouterr().out != shown


def test_wrong_rigs_in_model_files(tmp_path: Path) -> None:
    text = mechanisms.path("trailing_arm").read_text()
    wrong = {
        "has no section rig. Add it": text.partition("rig:")[0],
        "wheels": text.replace("carrier: arm", "carrier: arn"),
        'Did you mean "vehicle"': text.replace("  vehicle:", "  vehicel:"),
        "rig": text.partition("rig:")[0] + "rig: 5\n",
    }
    file = tmp_path / "own.yaml"
    for message, changed in wrong.items():
        file.write_text(changed)
        with pytest.raises(sr.SarrusError, match=message) as error:
            read_suspension_file(file, sr.load)
        assert "own.yaml" in str(error.value)
    file.write_text(text)
    assert sr.load(file).name == "trailing arm"


def test_carriers_whose_frames_are_in_the_middle(tmp_path: Path) -> None:
    text = mechanisms.path("double_wishbone").read_text()
    place = "position: [0, 0, 0], center_of_mass: [0, 0.75, 0.3]}"
    knuckle = "knuckle: {mass: 32, inertia: [0.8, 1.2, 0.8], "
    assert f"{knuckle}position: wheel}}" in text
    file = tmp_path / "middle.yaml"
    file.write_text(text.replace(f"{knuckle}position: wheel}}", knuckle + place))
    found = read_suspension_file(str(file), sr.load).analysed()
    for side in found.sides:
        for name in ("scrub_radius", "ride_steer", "roll_centre_height"):
            wanted = plain("double_wishbone").at(name, side=side)
            assert found.at(name, side=side) == pytest.approx(wanted, rel=1e-9), name
