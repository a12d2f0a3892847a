"""Arguments that cannot be meant are refused with the right call in the message; names tell what is measured."""

import pickle
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.workspace.analysis import checked_workspace
from sarrus.analyses.workspace.problem.formulation import formulate

from .mechanisms import arm, platform_equilateral

nan = float("nan")


@pytest.fixture(scope="module")
def two() -> tuple[sr.System, sr.Point]:
    return arm([1, 0.7])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"limits": {"q1": (nan, 1)}}, "limits: those of q1.angle must be a pair"),
        ({"limits": {"q1": 1}}, "limits: those of q1.angle must be a pair"),
        ({"limits": {"q1": (1, 2, 3)}}, "limits: those of q1.angle must be a pair"),
        ({"limits": {"q1": ("a", 2)}}, "limits: those of q1.angle must be a pair"),
        ({"limits": {"q1": "12"}}, "limits: those of q1.angle must be a pair"),
        ({"limits": {"q1": (0, 1), "q1.angle": (0, 2)}}, "limits: q1.angle is given twice"),
        ({"limits": [(0, 1)]}, "limits must be a dict"),
        ({"fixed": {"q1": nan}}, "fixed: q1.angle must keep a finite number"),
        ({"fixed": "q1"}, "fixed must be a list of names"),
        ({"seed": -1}, "seed must be 0 at least"),
        ({"repeats": 0}, "repeats must be 1 at least"),
        ({"longest": nan}, "longest must be a positive number"),
        ({"samples": 2.5}, "samples must be a whole number"),
        ({"time_limit": -1}, "time_limit must be a positive number"),
        ({"progress": 5}, "progress must be True"),
    ],
    ids=str,
)
def test_options(two: tuple[sr.System, sr.Point], options: dict[str, Any], message: str) -> None:
    system, tip = two
    with pytest.raises((sr.SarrusError, TypeError, ValueError), match=message):
        sr.workspace(system, tip["x", "y"], **options)


def test_what_is_mapped(two: tuple[sr.System, sr.Point]) -> None:
    system, tip = two
    x, y = tip["x", "y"]
    for output, message in (
        ((x, x), "given twice"),
        ("tool.x", "tool.x"),
        (5, "must be names"),
        ((), "one to three"),
    ):
        with pytest.raises((sr.SarrusError, TypeError), match=message):
            sr.workspace(system, output)
    with pytest.raises(TypeError, match=r"Call sr.workspace\(sr.System\(model\), ...\)"):
        sr.workspace(system.model, (x, y))  # type: ignore[arg-type]
    with pytest.raises(sr.SarrusError, match="is an output, which must be free"):
        sr.workspace(system, (x, y), fixed={x: 0.3})
    for analysis in (checked_workspace, sr.workspace_field):
        with pytest.raises(TypeError, match="found must be a Workspace, got System"):
            analysis(system)
    for gradient in (sr.area_gradient, sr.volume_gradient):
        with pytest.raises(TypeError, match="found must be a Workspace"):
            gradient(system, ["q1.point.x"])
    with pytest.raises(sr.SarrusError, match="require two outputs, got 1"):
        sr.input_singularities(system, x, ("q1", "q2"))
    with pytest.raises(sr.SarrusError, match="Give as many inputs"):
        sr.dexterity(system, system.q0, (x, y), ("q1",))
    with pytest.raises(sr.SarrusError, match="finite coordinates"):
        sr.dexterity(system, system.q0 * nan, (x, y), ("q1", "q2"))


def test_a_point_is_named_with_its_place(two: tuple[sr.System, sr.Point]) -> None:
    """The tip is not the origin of its body: 'link_2.x' on an axis was that of another point."""
    system, tip = two
    limits = {"q1": (-1.0, 1.0), "q2": (0.3, 2.0), "link_2.x": (0.6, None)}
    found = sr.workspace(system, tip["x", "y"], limits=limits, verify=False)
    assert found.outputs == ("link_2(0.7, 0, 0).x", "link_2(0.7, 0, 0).y")
    axes = found.plot()
    assert axes.get_xlabel() == "link_2(0.7, 0, 0).x [m]"
    assert axes.get_ylabel() == "link_2(0.7, 0, 0).y [m]"
    elbow = np.arccos(0.6)
    assert found.area == pytest.approx(2 * elbow * 0.7 * (np.cos(0.3) - np.cos(2.0)), rel=1e-6)
    same = sr.workspace(system, ("link_2(0.7, 0, 0).x", "link_2(0.7, 0, 0).y"), limits=limits, verify=False)
    assert same.outputs == found.outputs
    assert same.area == pytest.approx(found.area, rel=1e-9)


def test_legs_without_names_are_different_legs() -> None:
    """Three legs between the same two bodies have one name; their limits were those of one."""
    system, output, named = platform_equilateral()
    bare = {sr.Length(leg.point_i, leg.point_j): pair for leg, pair in named.items()}
    found = sr.workspace(system, output, limits=bare, verify=False)
    assert found.area == pytest.approx(2.986132374, rel=1e-6)
    causes = {name for curve in found.curves for name in curve.active}
    assert {cause.rpartition(" ")[0] for cause in causes} == {
        "ground-platform",
        "ground-platform (2)",
        "ground-platform (3)",
    }


def test_limits_with_units(two: tuple[sr.System, sr.Point]) -> None:
    system, tip = two
    degrees = {"q1": ("-60 deg", "60 deg"), "q2": ("10 deg", 2.0)}
    radians = {"q1": (-np.pi / 3, np.pi / 3), "q2": (np.pi / 18, 2.0)}
    areas = [
        sr.workspace(system, tip["x", "y"], limits=limits, samples=1, rays=1).area
        for limits in (degrees, radians)
    ]
    assert areas[0] == pytest.approx(areas[1], rel=1e-12)
    with pytest.raises(sr.SarrusError, match="must be in rad, or another unit of that kind"):
        sr.workspace(system, tip["x", "y"], limits={"q1": ("-60 m", "60 deg")})


def test_limits_in_degrees_without_a_unit_are_not_ignored_in_silence(two: tuple[sr.System, sr.Point]) -> None:
    system, tip = two
    with pytest.warns(sr.SarrusWarning, match=r"q1.angle: its limits, -60 and 60 rad, .* have no effect"):
        sr.workspace(system, tip["x", "y"], limits={"q1": (-60, 60)}, samples=1, rays=1)


def test_values_that_are_kept_are_numbers_of_any_kind(two: tuple[sr.System, sr.Point]) -> None:
    system, _ = two
    for value in (Fraction(1, 2), np.float32(0.5), 0.5):
        assert next(iter(formulate(system, ["q2"], fixed={"q1": value}).fixed.values())) == 0.5


def test_workspaces_can_be_pickled(two: tuple[sr.System, sr.Point]) -> None:
    system, tip = two
    found = sr.workspace(system, [tip["x"], tip["y"]], samples=2, rays=1, repeats=3)
    assert ". The last " in found.message
    assert pickle.loads(pickle.dumps(found)).area == found.area
