"""Every field of every part with values that mean nothing: each is refused by one message that names the part."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus.model import ModelError
from sarrus.model.expansion.blueprint import blueprint

A = sr.Body("a", mass=1.0, inertia=(1, 1, 1))
B = sr.Body("b", mass=1.0, inertia=(1, 1, 1), position=(0.0, 0.0, 1.0))
PIN = sr.Revolute("pin", A, B, point=(0, 0, 0), axis=(0, 0, 1))
PIN_2 = sr.Revolute("pin_2", sr.ground, A, point=(0, 0, 0), axis=(0, 0, 1))
BODIES: dict[str, Any] = {"body_i": A, "body_j": B}
POINT: dict[str, Any] = {**BODIES, "point": (0, 0, 0)}
AXIS: dict[str, Any] = {**POINT, "axis": (0, 0, 1)}
FRAMES: dict[str, Any] = {
    "frame_i": sr.Frame(sr.Point(A, (0, 0, 0)), z=(0, 0, 1)),
    "frame_j": sr.Frame(sr.Point(B, (0, 0, -1)), z=(0, 0, 1)),
}
ENDS: dict[str, Any] = {"point_i": A.point(0, 0, 0), "point_j": B.point(0, 0, 0)}
STOP: dict[str, Any] = {"stiffness": 1e3, "lower": -1.0, "upper": 2.0}
AT: dict[str, Any] = {"point": A.point(0, 0, 0)}
ROLLS: dict[str, Any] = {"radius": 0.3, "k": 1e5, "c": 10.0, "c_kappa": 1e4, "c_alpha": 1e4}
ROLLING = (
    "radius",
    "k",
    "c",
    "relaxation_x",
    "relaxation_y",
    "rolling_resistance",
    "rounding",
    "creep",
    "low_speed",
)
ROLLING += ("damping_time", "shortest_relaxation")
PARTS: list[tuple[Any, dict[str, Any]]] = [
    *((kind, AXIS) for kind in (sr.Revolute, sr.Cylindrical, sr.Translational, sr.Planar, sr.PointOnLine)),
    (sr.Revolute, FRAMES),
    (sr.PointOnPlane, AXIS),
    (sr.Screw, {**AXIS, "pitch": 0.1}),
    (sr.ParallelAxes, {**BODIES, "axis": (0, 0, 1)}),
    (sr.ConstantAngle, {**BODIES, "axis_i": (1, 0, 0.3), "axis_j": (0.2, 1, 0)}),
    (sr.Universal, {**POINT, "axis_i": (1, 0, 0), "axis_j": (0, 1, 0)}),
    (sr.Spherical, POINT),
    (sr.Fixed, POINT),
    (sr.Distance, ENDS),
    (sr.RevoluteSpherical, {**ENDS, "axis": (1, 0, 0)}),
    (sr.RevoluteRevolute, {**ENDS, "axis_i": (1, 0, 0), "axis_j": (1, 0, 0)}),
    (sr.Gear, {"joint_i": "pin", "joint_j": "pin_2", "ratio": -2.0}),
    (sr.Coupler, {"joint_i": "pin.angle", "joint_j": "pin_2.angle", "ratio": -2.0}),
    (sr.TSDA, {**ENDS, "k": 1.0, "length": 1.0, "c": 0.1, "force": 0.1}),
    (sr.RSDA, {**AXIS, "k": 1.0, "c": 0.1, "angle": 0.1, "torque": 0.1}),
    (sr.Drag, {**AT, "c": 0.1}),
    (sr.ViscousDrag, {**AT, "c": 0.1, "c_turn": 0.1}),
    (sr.PointForce, {**AT, "force": (1, 0, 0)}),
    (sr.Torque, {"body": A, "torque": (1, 0, 0)}),
    (sr.Bushing, {**POINT, "stiffness": (1.0,) * 6, "damping": (0.1,) * 6}),
    (sr.AngleFriction, {**AXIS, "load": 2.0, "mu": 0.2, "radius": 0.1}),
    (sr.DisplacementFriction, {**AXIS, "load": 2.0, "mu": 0.2}),
    (sr.Tyre, {**AT, "k": 1.0, "c": 0.1, "radius": 0.5}),
    (sr.RoadTyre, {**AT, "k": 1.0, "c": 0.1, "radius": 0.5}),
    (sr.BrushTyre, {**AT, **ROLLS, "mu": 1.0, "half_length": 0.1}),
    (sr.FialaTyre, {**AT, **ROLLS, "mu_max": 1.0, "mu_min": 0.8, "width": 0.2}),
    (sr.MagicFormulaTyre, {**AT, "coefficients": sr.load_tyre("passenger_car").coefficients}),
    (
        sr.SphereContact,
        {"center": A.point(0, 0, 0), "plane": sr.ground.frame((0, 0, -1)), "stiffness": 1e3, "radius": 0.1, "mu": 0.1},
    ),
    (sr.LengthStop, {**ENDS, **STOP, "lower": 0.1}),
    (sr.DisplacementStop, {**AXIS, **STOP}),
    (sr.AngleStop, {**AXIS, **STOP}),
    (sr.AngleDriver, {"joint": "pin", "motion": "t"}),
    (sr.DisplacementDriver, {"joint": "pin", "motion": "t"}),
    (sr.DistanceDriver, {**ENDS, "motion": "t + 1"}),
    (sr.PointDriver, {**AT, "x": "t", "z": 0.0}),
    (sr.CoordinateDriver, {"body": A, "coordinate": "x", "motion": "t"}),
    (sr.Body, {"mass": 1.0, "inertia": (1, 1, 1), "position": (0, 0, 0), "orientation": (1, 0, 0, 0)}),
]  # fmt: skip
NONSENSE: dict[str, Any] = {
    "nan": math.nan,
    "NumPy's nan": np.float64("nan"),
    "infinite": math.inf,
    "huge": -1e60,
    "no text": "",
    "bool": True,
    "no numbers": [],
    "one number": (1.0,),
    "nan in a vector": (math.nan, 0, 0),
    "object": object(),
    "mapping": {},
    "complex": 1j,
    "matrix of one": np.array([[1.0]]),
    "class": int,
    "function of nothing": lambda: 1,
    "function of text": lambda x: "a",
    "function of none": lambda x: None,
    "function of nan": lambda x: math.nan * x,
    "random function": lambda x: np.random.default_rng().normal() * x,
    "branching function": lambda x: x if x > 0 else 0.0,
    "one pair": [(0, 1)],
    "falling pairs": [(0, 1), (0, 2)],
    "nan in pairs": [(0, 1), (1, math.nan)],
    "list of bodies": [A],
    "frame on no point": sr.Frame(A, z=(0, 0, 1)),  # type: ignore[arg-type]
    "frame without a direction": sr.Frame(A.point(0, 0, 0), z=(0, 0, 0)),
}  # fmt: skip


def made(kind: Callable[..., Any], given: dict[str, Any]) -> None:
    """The model with one more part."""
    part = kind("x", **given)
    lists: dict[str, list[Any]] = {"bodies": [A, B], "joints": [PIN, PIN_2], "drivers": [], "forces": []}
    lists[next(name for name, some in sections(part).items() if some)].append(part)
    blueprint(sr.Model("m", **lists))


def sections(part: Any) -> dict[str, bool]:
    from sarrus.model.drivers import Driver
    from sarrus.model.forces import Force
    from sarrus.model.joints import Joint

    kinds = {"bodies": sr.Body, "joints": Joint, "drivers": Driver, "forces": Force}
    return {name: isinstance(part, kind) for name, kind in kinds.items()}


@pytest.mark.parametrize(("kind", "given"), PARTS, ids=lambda x: getattr(x, "__name__", ""))
def test_the_parts_of_the_table_are_good(kind: Any, given: dict[str, Any]) -> None:
    if kind is not sr.DisplacementDriver:  # a pin has no displacement: whatever it is given is refused
        made(kind, given)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("what", NONSENSE)
@pytest.mark.parametrize(("kind", "given"), PARTS, ids=lambda x: getattr(x, "__name__", ""))
def test_nonsense_is_refused(kind: Any, given: dict[str, Any], what: str) -> None:
    for field in fields(kind):
        may_be = what == "bool" and isinstance(field.default, bool)
        if not may_be and field.name not in ("name", "shape", "parameters", "over"):  # these may be empty
            with pytest.raises(ModelError, match=' "x": '):
                made(kind, {**given, field.name: NONSENSE[what]})


NEGATIVE: list[tuple[Any, tuple[str, ...]]] = [
    (sr.TSDA, ("k", "c", "length")),
    (sr.RSDA, ("k", "c")),
    (sr.Drag, ("c", "creep")),
    (sr.ViscousDrag, ("c", "c_turn")),
    (sr.AngleFriction, ("load", "mu", "radius", "mu_static", "stribeck", "creep", "viscous")),
    (sr.DisplacementFriction, ("load", "mu", "mu_static", "stribeck", "creep", "viscous")),
    (sr.Tyre, ("k", "c", "radius")),
    (sr.RoadTyre, ("k", "c", "radius", "rounding")),
    (sr.BrushTyre, (*ROLLING, "c_kappa", "c_alpha", "mu", "half_length")),
    (sr.FialaTyre, (*ROLLING, "c_kappa", "c_alpha", "mu_max", "mu_min", "width")),
    (sr.SphereContact, ("stiffness", "radius", "mu", "damping", "creep", "rounding", "exponent")),
    (sr.LengthStop, ("stiffness", "damping", "rounding", "exponent")),
    (sr.DisplacementStop, ("stiffness", "damping", "rounding", "exponent")),
    (sr.AngleStop, ("stiffness", "damping", "rounding", "exponent")),
    (sr.Distance, ("length",)),
    (sr.RevoluteSpherical, ("length",)),
    (sr.Body, ("mass",)),
]
MATRIX = np.diag([2.0, 2.0, 2.0, 1e-3, 1e-3, 1e-3])
COUPLED, LONELY = MATRIX.copy(), MATRIX.copy()
COUPLED[0, 4] = COUPLED[4, 0] = 0.1  # its determinant there is negative
LONELY[3, 3], LONELY[3, 0], LONELY[0, 3] = 0.0, 1e-3, 1e-3
SEAL = MATRIX.copy()
SEAL[0, 1], SEAL[1, 0] = 5.0, -5.0  # does work along circles, but none along lines


@pytest.mark.parametrize(("kind", "names"), NEGATIVE, ids=lambda x: getattr(x, "__name__", ""))
def test_negative_numbers_where_they_mean_nothing(kind: Any, names: tuple[str, ...]) -> None:
    given = next(given for one, given in PARTS if one is kind)
    for name in names:
        with pytest.raises(ModelError, match=rf' "x": .*{name}'):
            made(kind, {**given, name: -0.5})


@pytest.mark.parametrize("field", ["stiffness", "damping"])
@pytest.mark.parametrize("value", [(1, 1, -1, 1, 1, 1), COUPLED.tolist(), LONELY.tolist()], ids=range(3))
def test_a_bushing_that_gives_energy_is_refused(field: str, value: Any) -> None:
    given = next(given for one, given in PARTS if one is sr.Bushing)
    with pytest.raises(ModelError, match=f"{field} is negative in some direction"):
        made(sr.Bushing, {**given, field: value})
    for good in (MATRIX, 1e9 * MATRIX, SEAL, np.zeros((6, 6)), np.diag([0, 0, 1.0, 0, 0, 0])):
        made(sr.Bushing, {**given, field: good.tolist()})


def test_a_law_may_drive_a_motion() -> None:
    given = next(given for one, given in PARTS if one is sr.TSDA)
    made(sr.TSDA, {**given, "c": lambda rate: -0.5, "k": [(0, -1), (1, -1)]})
    with pytest.raises(ModelError, match="For an unstable spring or a driven damper give a law"):
        made(sr.TSDA, {**given, "c": -0.5})


@pytest.mark.parametrize("axis", [(0, 0, 0), (1e-13, 0, 0)])
def test_a_direction_without_length(axis: Any) -> None:
    for kind, given in PARTS:
        for field in given:
            if field.startswith("axis"):
                with pytest.raises(ModelError, match="zero length"):
                    made(kind, {**given, field: axis})


@pytest.mark.parametrize("gravity", [math.nan, (0, 0, math.nan), (0, 0), "down", None, True, (0, 0, True)])
def test_gravity(gravity: Any) -> None:
    with pytest.raises(ModelError, match="gravity"):
        blueprint(sr.Model("m", bodies=[A], gravity=gravity))


def test_a_random_law_is_refused() -> None:
    given = next(given for one, given in PARTS if one is sr.TSDA)
    with pytest.raises(ModelError, match="k is another function each time it is called"):
        made(sr.TSDA, {**given, "k": lambda x: 5 + np.random.default_rng().normal() * x})


TEXTS: list[tuple[Any, str, Any, str]] = [
    (sr.TSDA, "k", "50 + 10*abs(x - 2)", "x"),
    (sr.TSDA, "c", "step(x, 0, 1, 2, 3)", "x"),
    (sr.TSDA, "force", "5*sin(7*t)", "t"),
    (sr.RSDA, "torque", "max(t, 1)", "t"),
    (sr.RSDA, "k", "min(x**2, 3)", "x"),
    (sr.PointForce, "factor", "sin(t)", "t"),
    (sr.PointForce, "force", ["5*sin(7*t)", 0, "2"], "t"),
    (sr.Torque, "torque", [0, "1 + sign(t - 1)", 0], "t"),
    (sr.RoadTyre, "road", "0.1*sin(x)", "x"),
    (sr.RoadTyre, "bump", "0.05", "t"),
    (sr.BrushTyre, "road", "0.1*sin(x)", "x"),
]


@pytest.mark.parametrize(
    ("kind", "field", "text", "variable"), TEXTS, ids=lambda x: getattr(x, "__name__", str(x)[:9])
)
def test_forces_take_formulas_as_drivers_do(kind: Any, field: str, text: Any, variable: str) -> None:
    given = next(given for one, given in PARTS if one is kind)
    made(kind, {**given, field: text})
    other = {"x": "t", "t": "s"}[variable]
    wrong = [f"1 + {other}", 0, 0] if isinstance(text, list) else f"1 + {other}"
    with pytest.raises(ModelError, match=f'unknown name "{other}"'):
        made(kind, {**given, field: wrong})
