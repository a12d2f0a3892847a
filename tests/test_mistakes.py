"""Mistakes that people make: each gets one message that names the part and the remedy, or one warning."""

from __future__ import annotations

import contextlib
import inspect
import io
import math
import pydoc
import re
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import sarrus as sr
from sarrus import mechanisms
from sarrus.cli import main

DOWN = (0, 0, -9.81)


def arm(**given: Any) -> sr.Body:
    """A bar of 2 kg and 1 m."""
    return sr.Body("arm", **{"mass": 2.0, "inertia": (0.01, 0.2, 0.2), "position": (0.5, 0, 0), **given})


ARM = arm()


def pin(i: Any = sr.ground, j: Any = ARM, **given: Any) -> sr.Revolute:
    """A pin at the end of the arm, across it."""
    return sr.Revolute(given.pop("name", "pin"), i, j, **{"point": (0, 0, 0), "axis": (0, 1, 0), **given})


def system(
    bodies: Any = None, joints: Any = None, forces: Any = (), drivers: Any = (), **given: Any
) -> sr.System:
    """The pendulum, with other parts."""
    bodies, joints = [ARM] if bodies is None else bodies, [pin()] if joints is None else joints
    return sr.System(sr.Model("m", bodies, joints, forces, **{"gravity": DOWN, "drivers": drivers, **given}))


def spring(**given: Any) -> sr.TSDA:
    """From the arm to a point above it."""
    ends = {"point_i": sr.ground.point(0, 0, 1), "point_j": ARM.point(0.5, 0, 0)}
    return sr.TSDA("spring", **{**ends, "k": 100.0, "length": 1.0, **given})


def driver(motion: Any, joint: Any = "pin", name: str = "motor") -> sr.AngleDriver:
    return sr.AngleDriver(name, joint, motion=motion)


def other(motion: Any) -> sr.AngleDriver:
    return driver(motion, name="other")


def push(body: Any) -> sr.PointForce:
    return sr.PointForce("f", body.point(0, 0, 0), (1, 0, 0))


def coil(angle: float) -> sr.RSDA:
    return sr.RSDA("r", sr.ground, ARM, (0, 0, 0), (0, 1, 0), k=10, angle=angle)


def rod(length: float) -> sr.Distance:
    return sr.Distance("rod", sr.ground.point(0, 0, 1), ARM.point(0.5, 0, 0), length=length)


def lightest(bounds: tuple[float, float]) -> sr.Optimum:
    return sr.optimize(pendulum(), "arm.x", ["arm.mass"], bounds={"arm.mass": bounds}, until=0.1)


@cache
def pendulum() -> sr.System:
    return system()


@cache
def run() -> sr.Trajectory:
    return sr.simulate(pendulum(), until=0.05, store="steps")


def quarter_car(k: float, **given: Any) -> sr.System:
    """A chassis on a vertical slide and a coil spring."""
    chassis = sr.Body("chassis", 350.0, (50, 60, 70), position=(0, 0, 0.6))
    slide = sr.Translational("slide", sr.ground, chassis, point=(0, 0, 0), axis=(0, 0, 1))
    coil = sr.TSDA("coil", sr.ground.point(0, 0, 0), chassis.point(0, 0, 0), k=k, length=0.7)
    return system([chassis], [slide], [coil], **given)


def ball(normal: Any = (0, 0, 1), gravity: Any = DOWN) -> sr.System:
    """A ball over a plane."""
    body = sr.Body.sphere("ball", 0.1, mass=1.0, position=(0, 0, 1))
    plane = sr.ground.frame((0, 0, 0), z=normal)
    touch = sr.SphereContact("touch", body.point(0, 0, 0), plane, radius=0.1, stiffness=1e5)
    return system([body], [], [touch], gravity=gravity)


def weld() -> sr.Fixed:
    return sr.Fixed("weld", sr.ground, ARM, point=(0, 0, 0))


Mistake = tuple[str, Callable[[], Any], str, str]  # what, how, the part and the remedy in the message
REFUSED: list[Mistake] = [
    ("model for a system", lambda: sr.simulate(pendulum().model, until=1), "simulate", "sr.System(model)"),  # type: ignore[arg-type]
    ("file for a system", lambda: sr.simulate("a.yaml", until=1), "simulate", 'sr.load("a.yaml")'),  # type: ignore[arg-type]
    ("start and system swapped", lambda: sr.simulate(run().final, pendulum(), until=1), "simulate", "sr.System"),  # type: ignore[arg-type]
    ("no until", lambda: sr.simulate(pendulum(), 1.0), "simulate", "until=value"),  # type: ignore[call-arg, arg-type]
    ("until as a text", lambda: sr.simulate(pendulum(), until="1 m"), "until", "in s"),  # type: ignore[arg-type]
    ("until in the past", lambda: sr.simulate(pendulum(), until=-1), "until", "Give the time of the end in s"),
    ("until before the start", lambda: sr.simulate(pendulum(), run().final, until=0.01), "until", "Give the time"),
    ("SciPy's interval", lambda: sr.simulate(pendulum(), (0, 1), until=1), "7 finite numbers", "coordinates"),
    ("t_eval outside", lambda: sr.simulate(pendulum(), until=1, t_eval=[0, 2]), "t_eval", "numpy.linspace(0, 1"),
    ("t_eval not sorted", lambda: sr.simulate(pendulum(), until=1, t_eval=[0.5, 0.2]), "t_eval", "rising"),
    ("t_eval as a count", lambda: sr.simulate(pendulum(), until=1, t_eval=100), "t_eval", "Give a list"),
    ("option misspelt", lambda: sr.simulate(pendulum(), until=1, t_evals=1), "t_evals", 'mean "t_eval"'),  # type: ignore[call-arg]
    ("method as a text", lambda: sr.simulate(pendulum(), until=1, method="RK45"), "method", "Radau()"),  # type: ignore[arg-type]
    ("loose tolerance", lambda: sr.simulate(pendulum(), until=1, method=sr.Radau(rtol=10)), "rtol", "1e-6"),
    ("negative tolerance", lambda: sr.simulate(pendulum(), until=1, method=sr.Radau(rtol=-1)), "rtol", "1e-6"),
    ("run for a start", lambda: sr.simulate(pendulum(), run(), until=1), "start", "run.final"),  # type: ignore[arg-type]
    ("event as a function", lambda: sr.simulate(pendulum(), until=1, events=len), "events", "sarrus.Event"),  # type: ignore[arg-type]
    ("too many arguments", lambda: sr.workspace(pendulum(), "arm.x", "arm.z"), "workspace", "Name the others"),  # type: ignore[call-arg, arg-type]
    ("mass and inertia swapped", lambda: system([sr.Body("arm", (1, 1, 1), 2.0)]), 'body "arm": mass', "in kg"),  # type: ignore[arg-type]
    ("negative mass", lambda: system([arm(mass=-2.0)]), 'body "arm": mass', "in kg"),
    ("mass in another unit", lambda: system([arm(mass="2 m")]), 'body "arm": mass', "in kg"),
    ("no inertia", lambda: sr.Body("arm", mass=2.0), "Body: inertia", "inertia=value"),  # type: ignore[call-arg]
    ("inertia as a number", lambda: system([arm(inertia=0.2)]), 'body "arm": inertia', "3 principal moments"),
    ("inertia of a line", lambda: system([arm(inertia=(0, 1, 1))]), 'body "arm": inertia', "in kg m²"),
    ("triangle inequality", lambda: system([arm(inertia=(0.01, 0.2, 0.5))]), 'body "arm": inertia', "Check"),
    ("inertia by other keys", lambda: system([arm(inertia={"Ixx": 1})]), 'body "arm": inertia', 'mean "xx"'),
    ("name with a dot", lambda: system([sr.Body("a.b", 1, (1, 1, 1))]), 'body "a.b"', "Rename"),
    ("bodies of one name", lambda: system([ARM, arm()]), 'body "arm"', "Rename"),
    ("joint named as a body", lambda: system(joints=[pin(name="arm")]), 'joint "arm"', "Rename"),
    ("body not listed", lambda: system(joints=[pin(j=sr.Body("rod", 1, (1, 1, 1)))]), 'joint "pin"', "Choose from"),
    ("body by its name", lambda: system(joints=[pin(j="arm")]), 'joint "pin": body_j', "Body object"),
    ("joint with itself", lambda: system(joints=[pin(i=ARM)]), 'joint "pin"', "two different bodies"),
    ("joint without axis", lambda: system(joints=[pin(axis=None)]), 'joint "pin": axis', "Give point and axis"),
    ("axis of no length", lambda: system(joints=[pin(axis=(0, 0, 0))]), 'joint "pin": axis', "for example"),
    ("axis by a letter", lambda: system(joints=[pin(axis="y")]), 'joint "pin": axis', "three numbers"),
    ("joint among the bodies", lambda: system([ARM, pin()]), 'body "pin"', "Move it to joints"),
    ("no list", lambda: system(joints=pin()), "joints must be a list", "Write [...]"),
    ("gravity as a number", lambda: system(gravity=-9.81), "gravity", "(0, 0, -9.81)"),
    ("three angles", lambda: system([arm(orientation=(0, 0, 90))]), 'body "arm": orientation', "four numbers"),
    ("quaternion not unit", lambda: system([arm(orientation=(1, 1, 0, 0))]), 'body "arm": orientation', "add up to 1"),
    ("spring of no length", lambda: system(forces=[spring(point_i=sr.ground.point(1, 0, 0))]), "spring", "Move one"),
    ("negative stiffness", lambda: system(forces=[spring(k=-1.0)]), 'force "spring": k', "give a law"),
    ("no free length", lambda: sr.TSDA("s", ARM.point(0, 0, 0), ARM.point(1, 0, 0), k=1), "length", "length=value"),  # type: ignore[call-arg]
    ("force by formula misspelt", lambda: sr.Force("f", valu="3"), 'Force has no argument "valu"', 'mean "value"'),
    ("operator misspelt", lambda: system().operators.Ph, 'no operator "Ph"', 'Did you mean "Phi"'),
    ("field misspelt", lambda: spring(stiffness=1.0), 'TSDA has no argument "stiffness"', "Choose from"),
    ("bodies for points", lambda: system(forces=[spring(point_j=ARM)]), "spring", "body.point(x, y, z)"),
    ("table not sorted", lambda: system(forces=[spring(k=[(0, 1), (2, 1), (1, 1)])]), "spring", "Sort the pairs"),
    ("unknown joint", lambda: system(drivers=[driver("t", "pinn")]), 'driver "motor"', 'mean "pin"'),
    ("joint for its name", lambda: system(drivers=[driver("t", pin())]), 'driver "motor": joint', 'Give "pin"'),
    ("displacement of a pin", lambda: system(drivers=[sr.DisplacementDriver("d", "pin", "t")]), "pin", "pin.angle"),
    ("driver of a weld", lambda: system(None, [weld()], (), [driver("t", "weld")]), "weld", "Its coordinates"),
    ("variable of a formula", lambda: system(drivers=[driver("6*time")]), 'driver "motor"', "Choose from t"),
    ("math.sin", lambda: system(drivers=[driver(lambda t: math.sin(t))]), 'driver "motor"', "sarrus.functions"),
    ("gear with itself", lambda: system(None, [pin(), sr.Gear("g", "pin", "pin", 2)]), 'joint "g"', "two joints"),
    ("force on the ground", lambda: system(forces=[push(sr.ground)]), "f", "Name a body"),
    ("rod of no length", lambda: sr.Body.rod("r", (0, 0, 0), (0, 0, 0), mass=1), 'body "r"', "two points"),
    ("rod without mass", lambda: sr.Body.rod("r", (0, 0, 0), (0, 0, 1)), 'body "r"', "Give mass="),
    ("output misspelt", lambda: run().plot("amr.x"), "amr.x", 'mean "arm.x"'),
    ("group for an output", lambda: run().to_csv("run.csv", "energy"), "'energy'", "Choose from energy.kinetic"),
    ("body misspelt", lambda: run()["amr"], "amr", "mean"),
    ("joint misspelt", lambda: run().joint("pinn"), "pinn", 'mean "pin"'),
    ("response misspelt", lambda: sr.sensitivity(run(), sr.Final("arm.xx")), "arm.xx", 'mean "arm.x"'),
    ("wrt misspelt", lambda: sr.sensitivity(run(), "arm.x", wrt=["arm.mas"]), "arm.mas", 'mean "arm.mass"'),
    ("derivatives of a system", lambda: sr.sensitivity(pendulum(), "arm.x"), "need a run", "store='steps'"),  # type: ignore[arg-type]
    ("rate of an unknown joint", lambda: sr.assemble(pendulum(), rates={"pinn": 1}), "pinn", "mean"),
    ("bounds exchanged", lambda: lightest((3, 1)), "arm.mass", "Exchange"),
    ("class misspelt", lambda: sr.Revolut, "Revolut", 'mean "Revolute"'),
    ("outputs of a system", lambda: pendulum().outputs, "outputs", "sarrus.outputs.outputs_of(system)"),  # type: ignore[attr-defined]
    ("analysis as a method", lambda: pendulum().simulate(until=1), "simulate", "sarrus.simulate(system"),  # type: ignore[attr-defined]
    ("point as a list", lambda: ARM.point([0, 0, 1]), 'point of "arm"', "arm.point(x, y, z)"),  # type: ignore[call-arg, arg-type]
    ("point of two numbers", lambda: ARM.global_point(0, 1), 'point of "arm"', "arm.global_point(x, y, z)"),  # type: ignore[call-arg]
    ("class for a body", lambda: system([sr.Body]), "body", "List only Body objects"),
    ("model without a name", lambda: sr.System(sr.Model(3, [ARM], [pin()])), "name", "text"),  # type: ignore[arg-type]
    ("bodies by name", lambda: system({"arm": ARM}), "bodies must be a list", "Write [...]"),
    ("force of two components", lambda: system(forces=[sr.PointForce("f", ARM.point(0, 0, 0), (1, 0))]), "f", "three"),
    ("point of a force", lambda: system(forces=[sr.PointForce("f", (0, 0, 0), (1, 0, 0))]), "f", "body.point(x, y, z)"),
    ("driver among the joints", lambda: system(joints=[pin(), driver("t")]), '"motor"', "Move it to drivers"),
    ("rate as a text", lambda: sr.System(sr.Model("m", [ARM], [pin()], rates={"pin": "fast"})), "rates: pin", "rad/s"),  # type: ignore[dict-item]
    ("two arguments", lambda: system(drivers=[driver(lambda t, x: t)]), 'driver "motor": motion', "Use one argument"),
    ("nothing returned", lambda: system(drivers=[driver(lambda t: None)]), "returns nothing", "sarrus.functions"),
    ("maximum of Python", lambda: system(drivers=[driver(max)]), 'driver "motor": motion', "sarrus.functions"),
    ("hypotenuse of Python", lambda: system(drivers=[driver(math.hypot)]), "motor", "Expression"),
    ("sum with nothing", lambda: system(drivers=[driver(lambda t: t + {}.get("k"))]), "motor", "'NoneType'"),
    ("branch of a function", lambda: system(drivers=[driver(lambda t: 0 if t < 1 else 1)]), "motor", "branch"),
    ("wrt as a number", lambda: sr.sensitivity(run(), "arm.x", wrt=3), "wrt", "Give a list"),  # type: ignore[arg-type]
    ("moving point of a body", lambda: system(forces=[spring(point_j=ARM.point(0, 0, "t"))]), "arm", "sarrus.ground"),
    ("moving point misspelt", lambda: system(forces=[spring(point_i=sr.ground.point(0, 0, "tt"))]), "tt", "a number"),
    ("Euler parameters of 0", lambda: sr.simulate(pendulum(), [0.0] * 7, until=1), "arm", "Give [1, 0, 0, 0]"),
    ("start of another model", lambda: sr.simulate(pendulum(), [0.0] * 3, until=1), "7 finite numbers", "vector"),
    ("file ending", lambda: pendulum().model.save("m.txt"), "m.txt", ".yaml"),
    ("folder missing", lambda: run().to_csv("nofolder/run.csv"), "nofolder", "Make its folder"),
    ("speed of 1 number", lambda: system([arm(velocity=3)]), 'body "arm": velocity', "three numbers"),
    ("no such file", lambda: sr.load("nofile.yaml"), "nofile.yaml", "Check the path"),
]  # fmt: skip
FAILED: list[Mistake] = [
    ("two drivers that contradict", lambda: simulated(drivers=[driver("t"), other("2*t")]), "motor", "Give fewer"),
    ("driver of a locked joint", lambda: simulated(None, [pin(), weld()], (), [driver("t")]), "motor", "Give fewer"),
    ("loop that does not close", lambda: simulated(None, [pin(), rod(5.0)]), "rod by", "Start from"),
    ("motion without a driver", lambda: sr.kinematics(pendulum(), [0, 1]), "1 degree of freedom", "Add a driver"),
]  # fmt: skip
SUSPICIOUS: list[Mistake] = [
    ("inertia in kg mm²", lambda: system([arm(inertia=(1e4, 2e5, 2e5))]), "arm", "in kg m²"),
    ("joint in mm", lambda: system(joints=[pin(point=(1200, 0, 350))]), "pin", "lengths are in m"),
    ("body in mm", lambda: system([arm(position=(500, 0, 0))]), "pin", "lengths are in m"),
    ("centre of mass in mm", lambda: system([arm(center_of_mass=(300, 0, 0))]), "pin", "lengths are in m"),
    ("gravity in mm/s²", lambda: system(gravity=(0, 0, -9810)), "gravity", "in m/s²"),
    ("gravity upwards", lambda: ball(gravity=(0, 0, 9.81)), "touch", "Reverse gravity"),
    ("plane upside down", lambda: ball((0, 0, -1)), "touch", "normal of the plane"),
    ("degrees for radians", lambda: system([arm(orientation=sr.AxisAngle((0, 1, 0), 45))]), "arm", "0.785398 rad"),
    ("Euler angles in degrees", lambda: system([arm(orientation=sr.EulerAngles((0, 90, 0)))]), "arm", "1.5708 rad"),
    ("free angle in degrees", lambda: system(forces=[coil(90)]), "r", "1.5708 rad"),
    ("free length in mm", lambda: system(forces=[spring(length=1000)]), "spring", "in m"),
    ("stiffness in N/mm", lambda: quarter_car(20.0), "chassis", "k in N/m"),
    ("axis along the link", lambda: system(joints=[pin(axis=(1, 0, 0))]), "pin", "across the link"),
    ("table of a ramp", lambda: system(forces=[spring(force=[[0, 0], [1, 0], [1.1, 5], [2, 5]])]), "spring", "corners"),
    ("loose body", lambda: system([ARM, sr.Body("loose", 1.0, (1, 1, 1))]), "loose", "Attach it"),
    ("two drivers of one joint", lambda: system(drivers=[driver("t"), other("t")]), "other", "Remove one"),
    ("rate in degrees", lambda: system(drivers=[driver("360*t")]), "motor", "6.28319 rad"),
    ("rate in degrees by a function", lambda: system(drivers=[driver(lambda t: 180 * t)]), "motor", "3.14159 rad"),
    ("swing in degrees", lambda: system(drivers=[driver("45*sin(2*pi*t)")]), "motor", "0.785398 rad"),
    ("table in degrees", lambda: system(drivers=[driver(((0, 0), (1, 90), (2, 90)))]), "motor", "1.5708 rad"),
    ("points in the wrong bodies", lambda: linked((-0.5, 0, 0), (0.5, 0, 0)), "pin", "coincide if they are exchanged"),
    ("points in global axes", lambda: linked((1, 0, 0), (1, 0, 0)), "pin", "axes of its own body"),
    ("start off the constraints", lambda: sr.assemble(system(joints=[off()])), "m: assembly", "Correct the model"),
    ("nothing can move", lambda: sr.simulate(system(joints=[pin(), weld()]), until=0.1), "m", "Remove constraints"),
    ("start outside of bounds", lambda: lightest((3.0, 4.0)), "arm.mass", "starts"),
]  # fmt: skip


def linked(at_arm: Any, at_rod: Any) -> sr.System:
    """The arm and a rod that continues it, with a spherical joint between points in body axes."""
    rod = sr.Body("rod", 2.0, (0.01, 0.2, 0.2), position=(1.5, 0, 0))
    hinge = sr.Spherical("pin", point_i=ARM.point(*at_arm), point_j=rod.point(*at_rod))
    return system([ARM, rod], [pin(name="base"), hinge])


def simulated(*given: Any, **more: Any) -> sr.Trajectory:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sr.SarrusWarning)
        return sr.simulate(system(*given, **more), until=0.1)


def off() -> sr.Revolute:
    y = (0, 1, 0)
    return sr.Revolute("pin", frame_i=sr.ground.frame((0.3, 0, 0), z=y), frame_j=ARM.frame((-0.5, 0, 0), z=y))


def is_one_message(text: str) -> bool:
    """Whether it is on one line, short and ends as a sentence."""
    return "\n" not in text and len(text) < 400 and text.rstrip('"').endswith((".", "?"))


@pytest.mark.parametrize(
    ("mistake", "part", "remedy"), [one[1:] for one in REFUSED], ids=[one[0] for one in REFUSED]
)
def test_a_mistake_is_refused(mistake: Callable[[], Any], part: str, remedy: str) -> None:
    with pytest.raises((sr.SarrusError, TypeError, ValueError, KeyError, AttributeError)) as caught:
        mistake()
    text = str(caught.value.args[0] if isinstance(caught.value, KeyError) else caught.value)
    assert part in text
    assert remedy in text
    assert is_one_message(text)


@pytest.mark.parametrize(
    ("mistake", "part", "remedy"), [one[1:] for one in FAILED], ids=[one[0] for one in FAILED]
)
def test_a_mistake_is_the_reason_of_a_failure(mistake: Callable[[], Any], part: str, remedy: str) -> None:
    result = mistake()
    assert not result.success
    assert part in result.message
    assert remedy in result.message


@pytest.mark.parametrize(
    ("mistake", "part", "remedy"), [one[1:] for one in SUSPICIOUS], ids=[one[0] for one in SUSPICIOUS]
)
def test_what_is_suspicious_warns(mistake: Callable[[], Any], part: str, remedy: str) -> None:
    with pytest.warns(sr.SarrusWarning) as seen:
        result = mistake()
    texts = [str(one.message) for one in seen if issubclass(one.category, sr.SarrusWarning)]
    (text,) = texts
    assert text.startswith((part, f"{part}:"))
    assert remedy in text
    assert text in result.warnings


def test_the_signature_of_a_force_by_formula_is_readable() -> None:
    """That of `Force` itself is that of the class of its objects, and types are without units."""
    text = str(inspect.signature(sr.Force))
    assert "parameters: Mapping[str, float] = <factory>, value: Law | None = None, over: str" in text
    assert "Annotated" not in text


def test_help_shows_types_without_units_private_names_and_addresses() -> None:
    """Signatures of all classes, functions and methods, and what else `help` lists of a class."""
    for name in (name for name in sr.__all__ if not name.startswith("_")):
        shown = pydoc.plain(pydoc.render_doc(getattr(sr, name)))
        signatures = [line for line in shown.splitlines() if re.match(r"[ |]*[\w. =]+\(.*\)( -> .*)?$", line)]
        assert [line for line in signatures if re.search(r"[:\[|] ?'?_[A-Z]|\b0x[0-9a-f]+", line)] == []
        assert "Annotated[" not in shown, name


def test_results_carry_the_warnings_of_a_system_and_strict_raises_them() -> None:
    with pytest.warns(sr.SarrusWarning):
        odd = quarter_car(20.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert sr.assemble(odd).warnings == odd.warnings != ()  # issued once, when the system was made
    with pytest.raises(sr.StrictError, match="k in N/m"), sr.strict():
        sr.assemble(odd)
    with pytest.raises(sr.StrictError, match="k in N/m"), sr.strict():
        sr.System(odd.model)


EXAMPLES = sorted((Path(__file__).parent.parent / "examples").glob("*.yaml"))


@pytest.mark.parametrize(
    "file", [*map(mechanisms.path, mechanisms.names()), *EXAMPLES], ids=lambda file: Path(file).stem
)
def test_no_false_alarms(file: Any) -> None:
    assert sr.System(sr.load(file)).warnings == ()


def test_good_neighbours_of_mistakes_do_not_warn() -> None:
    assert quarter_car(20_000.0).warnings == ball().warnings == system(forces=[spring()]).warnings == ()
    assert system(joints=[pin(axis=(0, 0, 1))]).warnings == ()
    assert linked((0.5, 0, 0), (-0.5, 0, 0)).warnings == linked((0.5, 0, 0.2), (-0.5, 0.1, 0)).warnings == ()
    assert system(None, [pin(j=sr.ground, i=ARM)]).warnings == ()


@pytest.mark.parametrize(
    "motion",
    ["2*pi*t", "100*t", "314.159*t", "360 deg * t", "45 deg * sin(t)", "0.3*sin(60*t)", "50*sin(t)", "20*t**2",
     "90*t + sin(t)", "sqrt(t - 5)", ((0, 0), (1, 1.57)), lambda t: 500 * t],
)  # fmt: skip
def test_motions_in_radians_do_not_warn(motion: Any) -> None:
    assert system(drivers=[driver(motion)]).warnings == ()


FILE = """
name: m
gravity: [0, 0, -9.81]
bodies:
  arm: {mass: 2, inertia: [0.01, 0.2, 0.2], position: [0.5, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, arm], point: [0, 0, 0], axis: [0, 1, 0]}
forces:
  spring: {type: tsda, points: [{body: ground, at: [0, 0, 1]}, {body: arm, at: [0, 0, 0]}], k: 100, length: 1}
"""
EDITS = [  # old text, new text, the part and the remedy
    ("mass: 2", "mass: -2", 'body "arm": mass', "in kg"),
    ("mass: 2", "mass: 2 m", 'body "arm": mass', "kg"),
    ("mass: 2", "masss: 2", "masss", 'mean "mass"'),
    ("inertia: [0.01, 0.2, 0.2]", "inertia: [0.01, 0.2, 0.5]", 'body "arm": inertia', "Check"),
    ("inertia: [0.01, 0.2, 0.2], ", "", 'body "arm"', "inertia"),
    ("ground, arm]", "ground, amr]", 'joint "pin"', 'mean "arm"'),
    ("ground, arm]", "arm, arm]", 'joint "pin"', "two different bodies"),
    ("type: revolute", "type: revolut", 'joint "pin"', 'mean "revolute"'),
    ("axis: [0, 1, 0]", "axis: [0, 0, 0]", 'joint "pin": axis', "for example"),
    ("k: 100", "k: -100", 'force "spring": k', "law"),
    ("k: 100", "k: 100 N", 'force "spring": k', "N/m"),
    ("at: [0, 0, 1]", "at: [0.5, 0, 0]", 'force "spring"', "Move one"),
    ("  arm: {", "\tarm: {", "not valid YAML", "Check indentation"),
    ("mass: 2", "mass: two", 'body "arm": mass', "Write it as in"),
    ("mass: 2", "mass:", 'body "arm": mass', "Write it as in"),
    ("ground, arm]", "Ground, arm]", 'joint "pin"', 'mean "ground"'),
    ("ground, arm]", "arm]", 'joint "pin": bodies', "Give 2"),
    ("axis: [0, 1, 0]", "axis: y", 'joint "pin": axis', "in brackets"),
    ("point: [0, 0, 0]", "point: origin", 'joint "pin": point', "Define it under hardpoints"),
    ("at: [0, 0, 1]", "at: [0, 0, 1], global: [0, 0, 1]", 'force "spring": points[0]', "Give at"),
    ("k: 100", "k: 5*", 'force "spring": k', 'Check "5*"'),
    ("gravity:", "gravitiy:", "gravitiy", 'mean "gravity"'),
]
ODD = [
    ("inertia: [0.01, 0.2, 0.2]", "inertia: [1.0e4, 2.0e5, 2.0e5]", "arm", "in kg m²"),
    ("length: 1", "length: 1000", "spring", "in m"),
    ("-9.81", "-9810", "gravity", "in m/s²"),
    ("point: [0, 0, 0]", "point: [1200, 0, 0]", "pin", "lengths are in m"),
    ("position: [0.5, 0, 0]", "position: [0.5, 0, 0], orientation: {axis: [0, 1, 0], angle: 45}", "arm", "radians"),
]  # fmt: skip


def shell(file: Path) -> tuple[int, str]:
    """Exit code of `sarrus statics`, and what it writes to standard error."""
    text = io.StringIO()
    with contextlib.redirect_stderr(text), contextlib.redirect_stdout(io.StringIO()):
        code = main(["run", str(file), "--until", "0.01"])
    return code, text.getvalue()


@pytest.mark.parametrize(("old", "new", "part", "remedy"), EDITS)
def test_a_mistake_in_a_file_is_refused_in_python_and_in_the_shell(
    old: str, new: str, part: str, remedy: str, tmp_path: Path
) -> None:
    file = tmp_path / "m.yaml"
    file.write_text(FILE.replace(old, new), encoding="utf-8")
    with pytest.raises(sr.ModelError) as caught:
        sr.System(sr.load(file))
    text = str(caught.value)
    assert text.startswith(f"{file}:")
    assert part in text
    assert remedy in text
    code, told = shell(file)
    assert code == 2
    assert told.splitlines() == [f"sarrus: {text}"]


COMMANDS = [
    ("run m.yaml --untill 1", "--untill", 'Did you mean "--until"? See sarrus --help'),
    ("run m.yaml --until x", "--until", "sarrus run --help"),
    ("run m.yaml --until 1 --set b=2", "b", "Choose from|Remove it"),
    ("run m.yaml --until 1 --rate pim=2", "pim", 'mean "pin"'),
    ("rum m.yaml", "rum", 'mean "run"'),
    ("run no.yaml", "no.yaml", "Check the path"),
    ("sensitivity m.yaml", "--response", "sarrus sensitivity --help"),
    ("convert m.yaml m.doc", "m.doc", "must end in .yaml"),
]


@pytest.mark.parametrize(("command", "part", "remedy"), COMMANDS)
def test_a_mistake_in_a_command(
    command: str, part: str, remedy: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.yaml").write_text(FILE, encoding="utf-8")
    assert main(command.split()) == 2
    (text,) = capsys.readouterr().err.splitlines()
    assert part in text
    assert re.search(remedy if "|" in remedy else re.escape(remedy), text)


def test_there_are_more_than_sixty() -> None:
    assert len(REFUSED) + len(FAILED) + len(SUSPICIOUS) + len(EDITS) + len(ODD) + len(COMMANDS) >= 140


@pytest.mark.parametrize(("old", "new", "part", "remedy"), ODD)
def test_what_is_suspicious_in_a_file_warns(
    old: str, new: str, part: str, remedy: str, tmp_path: Path
) -> None:
    file = tmp_path / "m.yaml"
    file.write_text(FILE.replace(old, new), encoding="utf-8")
    with pytest.warns(sr.SarrusWarning, match=part):
        (text,) = sr.System(sr.load(file)).warnings
    assert remedy in text
    assert f"warning: {text}" in shell(file)[1].splitlines()


def test_angles_with_a_unit_do_not_warn(tmp_path: Path) -> None:
    file = tmp_path / "m.yaml"
    turned = "position: [0.5, 0, 0], orientation: {axis: [0, 1, 0], angle: 720 deg}"
    file.write_text(FILE.replace("position: [0.5, 0, 0]", turned), encoding="utf-8")
    assert sr.System(sr.load(file)).warnings == ()
