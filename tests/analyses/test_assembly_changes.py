"""What assembly changes of a model's positions and velocities is reported, and nothing else is."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus.cli import main

RATE = 5.236
Z = (0.0, 0.0, 1.0)


def arm(omega: float = 0.0, place: float = 0.5, speed: float = 0.0) -> sr.System:
    """A link that turns about a point half a metre beside its origin."""
    link = sr.Body(
        "crank", 1.0, (1.0, 1.0, 1.0), (place, 0.0, 0.0), velocity=(0.0, speed, 0.0), angular_velocity=(0.0, 0.0, omega)
    )  # fmt: skip
    pin = sr.Revolute("pin", frame_i=sr.ground.frame((0, 0, 0), z=Z), frame_j=link.frame((-0.5, 0, 0), z=Z))
    return sr.System(sr.Model("arm", [link], [pin]))


def test_an_angular_velocity_that_contradicts_the_joint_is_reported_with_both_values() -> None:
    """The given ω alone makes the pin's point move; the nearest admissible motion has another ω, by least squares."""
    system = arm(RATE)
    J = system.Phi_q(system.q0).toarray()
    length = 2 * np.sqrt(
        (0.5**2 + 2 * 0.25**2) / 3
    )  # of the lever arm, the body's origin and the point on the ground
    J_W = J * np.array([length**2] * 3 + [1.0] * 4)
    nearest = system.v0 - J_W.T @ np.linalg.lstsq(J_W @ J.T, J @ system.v0, rcond=None)[0]
    omega = 2 * nearest[6]
    with pytest.warns(sr.SarrusWarning, match=f"angular velocity {RATE} became {omega:.4g} rad/s"):
        start = sr.assemble(system)
    assert start.changes == (
        f"crank: velocity 0 became {0.5 * omega:.4g} m/s",
        f"crank: angular velocity {RATE} became {omega:.4g} rad/s",
    )
    assert "Correct the model" in start.warnings[0]
    with pytest.warns(sr.SarrusWarning, match="angular velocity"):
        assert sr.simulate(system, until=0.01).warnings == start.warnings
    with pytest.raises(sr.StrictError, match="angular velocity"), sr.strict():
        sr.assemble(system)


def test_a_consistent_velocity_and_one_rounded_to_four_digits_are_not_reported() -> None:
    for speed in (0.5 * RATE, round(0.5 * RATE, 3)):
        assert sr.assemble(arm(RATE, speed=speed)).changes == ()


GIVEN: list[tuple[dict[str, Any], dict[str, Any]]] = [
    ({"velocity": (0, 2, 0)}, {}),
    ({"angular_velocity": (0, 0, 2)}, {}),
    ({}, {"angular_velocity": (0, 0, 3)}),
    ({"angular_velocity": (0, 0, 2)}, {"velocity": None}),
]


@pytest.mark.parametrize(("crank", "rocker"), GIVEN)
def test_a_given_velocity_holds_and_all_others_follow(crank: dict[str, Any], rocker: dict[str, Any]) -> None:
    """A four-bar of revolutes: rank 3 too few; its rates follow from the loop, cross(ω1, a) + cross(ω2, b) = ..."""
    bodies = [
        sr.Body("crank", 1.0, (0.1, 0.1, 0.1), (1, 0, 0), **crank),
        sr.Body("coupler", 1.0, (0.1, 0.1, 0.1), (2.3, 0.4, 0)),
        sr.Body("rocker", 1.0, (0.1, 0.1, 0.1), (3.5, -0.1, 0), **rocker),
    ]
    places = np.array([(0, 0, 0), (2, 0, 0), (2.7, 0.7, 0), (4, -1, 0)])
    pairs = zip([sr.ground, *bodies], [*bodies, sr.ground], places, strict=True)
    joints = [sr.Revolute(f"j{n}", i, j, point=tuple(p), axis=Z) for n, (i, j, p) in enumerate(pairs)]
    start = sr.assemble(sr.System(sr.Model("four-bar", bodies, joints)))
    assert start.success
    assert start.changes == ()
    links = np.diff(places[:, :2], axis=0)
    ratios = np.linalg.solve(np.array([[-y, x] for x, y in links[1:]]).T, [links[0][1], -links[0][0]])
    unit = 2.0 if crank else 3.0 / ratios[1]
    assert start.v[6::7] * 2 == pytest.approx(unit * np.array([1.0, *ratios]), rel=1e-8)
    assert start.v[0:2] == pytest.approx([0.0, unit], rel=1e-8, abs=1e-8)


def test_gradients_by_given_velocities_of_one_body() -> None:
    """Closed form: a link on a pin turns with v/l, whichever of both is given."""
    for given, rate in (({"velocity": (0, 3.0, 0)}, 2.0), ({"angular_velocity": (0, 0, 6.0)}, 1.0)):
        link = sr.Body("crank", 1.0, (1.0, 1.0, 1.0), (0.5, 0.0, 0.0), **given)
        pin = sr.Revolute("pin", sr.ground, link, point=(0, 0, 0), axis=Z)
        run = sr.simulate(sr.System(sr.Model("arm", [link], [pin])), until=0.5, store="steps")
        assert run["pin.angle"][-1] == pytest.approx(3.0, rel=1e-9)
        names = [f"crank.{next(iter(given))}.{axis}" for axis in "xyz"]
        found = sr.sensitivity(run, "pin.angle", names).matrix[0]
        assert found == pytest.approx([0.0, 0.5 * rate, 0.0] if rate == 2.0 else [0.0, 0.0, 0.5], abs=1e-7)
        with pytest.raises(sr.SarrusError, match="is not given"):
            sr.sensitivity(run, "pin.angle", ["crank.velocity" if rate == 1.0 else "crank.angular_velocity"])


def test_velocities_of_zero_are_completed_without_a_word() -> None:
    """Who gives the speed of one end of a chain expects that the other bodies follow."""
    tip = sr.Body("tip", 1.0, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), velocity=(0.0, 2.0, 0.0))
    rider = sr.Body("rider", 1e-3, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
    slide = sr.Translational("slide", sr.ground, tip, point=(0, 0, 0), axis=(0, 1, 0))
    tie = sr.Fixed("tie", tip, rider, point=(0, 0, 0))
    system = sr.System(sr.Model("chain", [tip, rider], [slide, tie]))
    start = sr.assemble(system, fixed=["tip"])
    assert start.v[8] == pytest.approx(2.0)
    assert start.changes == ()


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e4])
def test_positions_count_by_the_size_of_the_mechanism(scale: float) -> None:
    def model(place: float) -> sr.System:
        link = sr.Body("crank", 1.0, (1.0, 1.0, 1.0), (place * scale, 0.0, 0.0))
        i, j = sr.ground.frame((0, 0, 0), z=Z), link.frame((-0.5 * scale, 0, 0), z=Z)
        return sr.System(sr.Model("arm", [link], [sr.Revolute("pin", frame_i=i, frame_j=j)]))

    assert sr.assemble(model(0.5 + 2e-4)).changes == ()
    with pytest.warns(sr.SarrusWarning, match="crank: position"):
        start = sr.assemble(model(0.52))
    assert start.changes[0].startswith(f"crank: position ({0.52 * scale:.4g}, 0, 0) became (")


def test_a_turned_body_is_reported() -> None:
    """A driver holds the pin at 10 degrees, where the link is drawn at 0."""
    system = arm()
    hold = sr.AngleDriver("hold", "pin", np.radians(10))
    driven = sr.System(replace(system.model, drivers=[hold]))
    with pytest.warns(sr.SarrusWarning, match="orientation changed by"):
        sr.assemble(driven)


def test_a_guess_that_is_given_is_no_claim() -> None:
    system = arm()
    start = sr.assemble(system, system.q0 + 0.1)
    assert start.changes
    assert start.warnings == ()


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A model file whose crank has a velocity that the pin does not allow."""
    place = tmp_path / "arm.yaml"
    place.write_text(
        "name: arm\n"
        "bodies:\n"
        f"  crank: {{mass: 1, inertia: [1, 1, 1], position: [0.5, 0, 0], velocity: [0, 0, 0], "
        f"angular_velocity: [0, 0, {RATE}]}}\n"
        "joints:\n"
        "  pin: {type: revolute, bodies: [ground, crank], point: [0, 0, 0], axis: [0, 0, 1]}\n"
    )
    return place


def test_the_shell_shows_a_warning_once(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(file), "--until", "0.01", "-q"]) == 0
    shown = capsys.readouterr()
    assert shown.err.count("warning: arm: assembly changed") == 1
    assert "warning" not in shown.out
    assert main(["run", str(file), "--until", "0.01", "-q", "--strict", "--json"]) == 1
    answer = json.loads(capsys.readouterr().out)
    assert not answer["success"]
    assert "angular velocity" in answer["warnings"][0]


def test_check_reports_what_assembly_changes(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["check", str(file), "-q"])
    assert f"crank: angular velocity {RATE} became" in capsys.readouterr().err


def test_searches_and_studies_report_what_is_changed_of_the_models_own_state() -> None:
    """Poses of other designs are guesses: the model's own state is none, whichever design is the best."""
    system, goal = arm(RATE), sr.Final(lambda o: o("crank.x") + (o.parameter("crank.mass") - 2) ** 2)
    with pytest.warns(sr.SarrusWarning, match="angular velocity"):
        expected = sr.simulate(system, until=0.01).warnings
    with pytest.warns(sr.SarrusWarning, match="angular velocity"):
        found = sr.optimize(
            system, goal, ["crank.mass"], until=0.01, bounds={"crank.mass": (0.5, 5.0)}, starts=2
        )
    assert found.x[0] == pytest.approx(2.0, abs=0.01)
    assert found.warnings == expected
    given = {"crank.mass": [2.0, 3.0]}
    with pytest.warns(sr.SarrusWarning, match="angular velocity"):
        table = sr.study(system, given, "final(crank.x)", analysis=sr.Simulation(0.01), workers=1)
    assert table.warnings == expected
    with pytest.raises(sr.StrictError, match="angular velocity"), sr.strict():
        sr.study(system, given, "final(crank.x)", analysis=sr.Simulation(0.01), workers=1)
