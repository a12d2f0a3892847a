"""A model with every kind of joint, driver and force that model files can contain, and its outputs by kind of part."""

from __future__ import annotations

import warnings
from functools import cache
from typing import Any

import numpy as np
from tests.sensitivity.zoo import Builder, _couplings, _forces, _joints

import sarrus as sr
from sarrus.outputs import Output, outputs_of

UNTIL = 0.02
OIL = {
    "area": 2e-6,
    "rod_area": 1e-6,
    "dead": 1e-7,
    "supply": 1e6,
    "rated_flow": 1e-6,
    "rated_drop": 1e5,
    "bulk": 1e7,
}
CURVES: dict[str, tuple[float, float]] = {
    "slope": (20.0, 35.0),
    "peak_slip": (0.2, 0.25),
    "peak_force": (2.0, 3.5),
    "sliding_slip": (0.8, 0.9),
    "sliding_force": (1.5, 2.8),
}
TMEASY: dict[str, Any] = {f"{name}_{axis}": pair for name, pair in CURVES.items() for axis in "xy"}
TMEASY |= {"nominal_load": 3.0}
LIGHT = {
    "FNOMIN": 5.0,
    "FZMIN": 0.0,
    "FZMAX": 20.0,
    "VERTICAL_STIFFNESS": 30.0,
    "VERTICAL_DAMPING": 0.1,
    "Q_FZ2": 0.2,
}
LIGHT |= {"LONGITUDINAL_STIFFNESS": 200.0, "LATERAL_STIFFNESS": 90.0}
COEFFICIENTS = {**sr.load_tyre("passenger_car").coefficients, **LIGHT}
POINT = "body_3(0.1, 0.2, 0.3)"


def _rest_of_joints(b: Builder) -> None:
    b.pair(sr.Cartesian, "gantry")
    one, two = b.body(), b.body()
    b.joints.append(sr.Spherical("knuckle", sr.ground, one, point=b.near(one)))
    ends = {"axis_i": (0.3, 0.2, 1), "axis_j": (0.1, -1, 0.4)}
    b.joints.append(sr.RevoluteRevolute("arm_link", b.spot(one), b.spot(two), **ends))


def _cam(b: Builder) -> None:
    shaft, tappet = b.body(), b.body()
    b.joints += [
        sr.Revolute("shaft", sr.ground, shaft, point=b.near(shaft), axis=b.axis()),
        sr.Translational("tappet", sr.ground, tappet, point=b.near(tappet), axis=b.axis()),
        sr.FormulaCoupler("cam", "tappet", value="0.1*sin(3*shaft.angle) + 0.2*shaft.angle^2"),
    ]


def _rolling(b: Builder) -> None:
    plane = sr.ground.frame((0, 0, -0.4))
    on_plane = {"plane": plane, "radius": 0.4}
    sphere, disc, wheel, skate = (b.body() for _ in range(4))
    b.joints += [
        sr.RollingSphere("marble", center=sphere.point(0, 0, 0), **on_plane),
        sr.RollingDisc("coin", center=disc.point(0, 0, 0), axis=(0.1, 1, 0.2), **on_plane),
        sr.RollingWheel("castor", center=wheel.point(0, 0, 0), axis=(0.3, 1, 0), **on_plane),
        sr.KnifeEdge("blade", point=b.spot(skate), axis=b.axis()),
    ]


def _drivers(b: Builder) -> None:
    b.pair(sr.Revolute, "motor")
    b.drivers.append(sr.AngleDriver("turn", "motor", "0.1*sin(3*t)"))
    b.pair(sr.Translational, "ram")
    b.drivers.append(sr.DisplacementDriver("push", "ram", "0.1*sin(3*t)"))
    one, two, three, four = (b.body() for _ in range(4))
    b.joints.append(sr.Spherical("socket", sr.ground, one, point=b.near(one)))
    far = float(np.linalg.norm(np.subtract(two.position, one.position)))
    ends = one.point(0, 0, 0), two.point(0, 0, 0)
    b.drivers.append(sr.DistanceDriver("jack", *ends, f"{far!r} + 0.05*sin(2*t)"))
    b.drivers.append(sr.CoordinateDriver("lift", three, "z", f"{three.position[2]!r} + 0.05*sin(2*t)"))
    x, _, z = four.position
    b.drivers.append(sr.PointDriver("path", four.point(0, 0, 0), x=f"{x!r} + 0.1*t", z=f"{z!r} + 0.1*t^2"))


def _driveline(body: sr.Body) -> list[sr.Force]:
    """From an engine to two hinges, with everything between them; a motor and a brake; the place along a path."""
    x, y, _ = body.position
    return [
        sr.Shaft("crank", inertia=0.2, torque="engine.value - converter.value", initial=30.0),
        sr.Shaft("turbine", inertia=0.3, torque="converter.output - gearbox.value", initial=9.0),
        sr.Engine("engine", "crank", "0.4 + 0.1*pin.angle", [[0, 2], [100, 3], [200, 2]], "-0.001*x"),
        sr.TorqueConverter("converter", "crank", "turbine", 2e-3, "2 - x"),
        sr.Transmission("gearbox", "turbine", "halves", 3.0, 5.0, 0.9, creep=2.0),
        sr.Differential("halves", "wheel_0", "wheel_1", 2.5, "gearbox.output", 0.1, 0.2),
        sr.ElectricMotor("starter", "pin", "0.3 - pin.angle", torque=2.0, power=9.0),
        sr.Brake("band", "pin", "0.2 + 0.1*t", creep=0.5),
        sr.PathFollower("course", body.name, [[x - 2, y - 1], [x, y], [x + 2, y + 2]], initial=5**0.5),
    ]


def _texts(b: Builder) -> None:
    """Forces of the zoo with functions in Python, which files cannot contain, as formulas."""
    _forces(b)
    texts = {"wave": "force", "fan": "force", "swing": "torque", "rotor": "torque"}
    loads = [one for one in b.forces if one.name in texts]
    b.forces = [one for one in b.forces if one.name not in (*texts, "wheel")]
    for one in loads:
        body = {"body": one.body} if hasattr(one, "body") else {"point": one.point}
        b.forces.append(type(one)(one.name, **body, axes=one.axes, **{texts[one.name]: ("sin(t)", 0.2, 0.1)}))
    one, two = b.bodies[0], b.bodies[1]
    road = {"radius": 0.7, "road": "0.1*sin(x)", "rounding": 0.1}
    b.forces += [
        sr.RoadTyre("wheel", b.spot(two), k=30.0, c=1.0, **road),
        sr.BrushTyre(
            "brush", b.spot(two), k=30.0, c=1.0, c_kappa=20.0, c_alpha=30.0, mu=0.8, axis=b.axis(), **road
        ),
        sr.FialaTyre(
            "slick", b.spot(one), k=30.0, c_kappa=20.0, c_alpha=30.0, mu_max=0.8, axis=b.axis(), **road
        ),
        sr.TmeasyTyre("tmeasy", b.spot(one), k=30.0, axis=b.axis(), **TMEASY, **road),
        sr.MagicFormulaTyre(
            "radial", b.spot(two), coefficients=COEFFICIENTS, axis=b.axis(), road=road["road"]
        ),
        sr.CartesianSpring("rubber", b.spot(one), b.spot(two), stiffness=(9, 8, 7), damping=(0.3, 0.2, 0.1)),
        sr.SphericalSpring("gimbal", one, two, point=b.near(two), k=2.0, c=0.1, friction=0.2, creep=0.2),
        sr.SphericalInertia("gyro", one, two, inertia=0.2),
        sr.BoxDrag(
            "water", two.frame((0.1, 0.2, 0.1)), (0.2, 0.3, 0.1), density=3.0, viscosity=0.2, creep=0.1
        ),
        sr.EllipsoidDrag(
            "air", one.frame((0.1, 0.2, 0.1)), (0.2, 0.3, 0.1), density=3.0, viscosity=0.2, creep=0.1
        ),
        sr.Force("muscle", b.spot(one), b.spot(two), value="3 - 0.5*v - x^2"),
        sr.Force("piston", joint="slide", value="2*sin(5*t) - 0.3*v"),
        sr.Torque("servo", joint="pin", value="k*(0.2 - x) - 0.1*v", parameters={"k": 4.0}),
        sr.StateVariable(
            "current", rate="(1 - 2*current - 0.1*pin.rate)/L", initial=0.2, unit="A", parameters={"L": 0.5}
        ),
        sr.Input("command", "0.1*sin(3*t)", unit="rad"),
        sr.FirstOrderLag("sensor", input="pin.angle - command", time=0.1),
        sr.TransferFunction("filter", input="sensor", numerator=[1, 2], denominator=[1, 3, 2]),
        sr.StateSpaceBlock("plant", A=[[-1.0]], B=[[1.0, 0.5]], C=[[1.0]], inputs=["pin.rate", "sensor"]),
        sr.PID("pid", input="0.2 - filter.output", kp=1.0, ki=2.0, kd=0.1, filter=0.05, lower=-1.0, unit="V"),
        sr.Maxwell("maxwell", joint="slide", k=9.0, c=2.0, initial=0.3),
        sr.LuGre("bristles", "pin", 2.0, 0.1, 300.0, mu_static=0.2, damping=0.5, creep=1e-3, radius=0.1),
        sr.HydraulicCylinder(
            "jack_h", joint="slide", input="0.2 - pin.angle", retracted=-1.0, stroke=2.0, **OIL
        ),
        sr.PneumaticChamber(
            "gas", joint="slide", input="1e-6*pin.rate", area=1e-6, dead=1e-4, retracted=-1.0
        ),
        sr.Tendon(
            "cable", [b.spot(one), b.spot(two), two.point(0.1, 0, 0.9)], value="-3*max(x - 0.2, 0) - 0.1*v"
        ),
        sr.Tendon("sinew", joints={"pin": 0.3, "slide": -2.0}, value="-k*x - 0.1*v", parameters={"k": 4.0}),
        sr.MuscleActivation("effort", input="0.4 + pin.angle", smoothing=0.5, initial=0.2),
        sr.Muscle(
            "biceps",
            joints={"pin": 0.3},
            activation="effort",
            peak_force=2.0,
            optimal_length=0.5,
            tendon_length=-0.5,
        ),
        sr.DCMotor("dc", "pin", "pid.output", resistance=1.0, inductance=0.1, constant=0.05, gear=3.0),
    ]
    b.forces += _driveline(one)


@cache
def system() -> sr.System:
    """All of them in one system."""
    builder = Builder(0)
    for add in (_joints, _couplings, _rest_of_joints, _cam, _rolling, _drivers, _texts):
        add(builder)
    parts = {"joints": builder.joints, "drivers": builder.drivers, "forces": builder.forces}
    return sr.System(sr.Model("every kind", builder.bodies, gravity=(0.1, 0.2, -2.0), **parts))


@cache
def run() -> sr.Trajectory:
    """A short motion, whose stored times include the end."""
    times = {"until": UNTIL, "t_eval": np.linspace(0, UNTIL, 5)}
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*assembly changed")  # poses are random
        method = sr.Radau(rtol=1e-10, atol=1e-12)
        return sr.simulate(system(), **times, method=method, store="steps")


def parts() -> dict[str, Any]:
    """Joints, drivers and forces by name."""
    model = system().model
    return {part.name: part for part in (*model.joints, *model.drivers, *model.forces)}


@cache
def outputs() -> dict[str, Output]:
    """Every output of one part of each kind, of a body, a point, the energies and the time.

    Of a vector it has one component, which one changes from vector to vector.
    """
    found: dict[tuple[str, str], list[Output]] = {}
    own, first = parts(), dict[str, str]()
    for one in (*outputs_of(system()), *outputs_of(system(), POINT)):
        part, _, word = one.name.removeprefix(POINT).partition(".")
        kind = type(own[part]).__name__ if part in own else part.partition("_")[0]
        if first.setdefault(kind, part) == part:
            vector = word.rpartition(".")[0] if word[-2:] in (".x", ".y", ".z") else word
            found.setdefault((kind, vector), []).append(one)
    return {one.name: one for n, group in enumerate(found.values()) for one in [group[n % len(group)]]}
