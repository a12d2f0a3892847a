"""Every function of formulas, under the same name as a text, in a file and in Python, in every place of a formula."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.outputs.every_kind import COEFFICIENTS, TMEASY
from tests.outputs.every_kind import system as of_every_kind

import sarrus as sr
from sarrus import functions
from sarrus._jit.formulas.expression import Graph, Node
from sarrus.analyses.sensitivity.parameters.parameters import Parameters
from sarrus.model.expression.functions import FUNCTIONS
from sarrus.model.laws.jumps import refuse_recorded_jumps
from sarrus.model.measure import measures_of
from sarrus.model.written import numbers_in_jumps, written_numbers

CALLS = {name: f"{name}(u)" for name in ("sin", "cos", "tan", "atan", "exp", "tanh", "abs", "deg", "rad")} | {
    "asin": "asin(u/9)", "acos": "acos(u/9)", "sqrt": "sqrt(1 + u**2)", "log": "log(2 + u**2)", "atan2": "atan2(u, 2)",
    "hypot": "hypot(u, 1)", "min": "min(u, 0.1)", "max": "max(u, 0.2)", "step": "step(u, -1, 0, 1, 1)",
    "sign": "sign(u - 0.1)", "floor": "floor(u - 0.1)", "mod": "mod(u, 0.1)",
}  # fmt: skip
JUMPS = ("sign(u - 0.1)", "step(u - 0.1)", "floor(u - 0.1)", "mod(u, 0.1)")
SMOOTH = [one for one in CALLS.values() if one not in JUMPS]
# In laws of one variable, which are short programs, and refuse a function of two that is none of their operations
FEW = "0.01*(" + " + ".join(one for one in SMOOTH if one != CALLS["atan2"]) + ")"
EVERY = f"{FEW} + 0.01*{CALLS['atan2']}"
X = (1, 0, 0)
CRANK = sr.Body("crank", 1.0, (0.1, 0.2, 0.3), position=(0.3, 0.1, 0.2))
BLOCK = sr.Body("block", 1.0, (0.1, 0.2, 0.3), position=(0.4, -0.2, 0.5))
WHEEL = sr.Body("wheel", 1.0, (0.1, 0.2, 0.3), position=(0.2, 0.7, 0.3))
JOINTS = [
    sr.Revolute("pin", sr.ground, CRANK, point=(0, 0, 0), axis=(0, 0, 1)),
    sr.Translational("slide", sr.ground, BLOCK, point=(0, 0, 0), axis=X),
    sr.Spherical("knob", CRANK, WHEEL, point=(0.2, 0.7, 0.3)),
]
A, B, C = sr.ground.point(0.1, 0.2, 0.9), BLOCK.point(0.1, 0, 0), WHEEL.point(0, 0, 0)
COIL = {"point": (0, 0, 0), "axis": (0, 0, 1)}
OF_OUTPUTS = {
    "Drag.c",
    "Force.value",
    "Torque.value",
    "Tendon.value",
    "Input.value",
    "DCMotor.voltage",
    "Muscle.activation",
}  # or of names
PLACES: dict[str, tuple[str, Callable[[Any], Any]]] = {  # the variable, and a part with a formula
    "AngleDriver.motion": ("t", lambda f: sr.AngleDriver("p", "pin", f)),
    "DisplacementDriver.motion": ("t", lambda f: sr.DisplacementDriver("p", "slide", f)),
    "DistanceDriver.motion": ("t", lambda f: sr.DistanceDriver("p", A, B, f)),
    "CoordinateDriver.motion": ("t", lambda f: sr.CoordinateDriver("p", BLOCK, "z", f)),
    "PointDriver.x": ("t", lambda f: sr.PointDriver("p", B, x=f)),
    "PointDriver.y": ("t", lambda f: sr.PointDriver("p", B, y=f)),
    "PointDriver.z": ("t", lambda f: sr.PointDriver("p", B, z=f)),
    "TSDA.k": ("x", lambda f: sr.TSDA("p", A, B, k=f, length=0.3)),
    "TSDA.c": ("x", lambda f: sr.TSDA("p", A, B, k=1.0, c=f, length=0.3)),
    "TSDA.force": ("t", lambda f: sr.TSDA("p", A, B, k=1.0, force=f, length=0.3)),
    "RSDA.k": ("x", lambda f: sr.RSDA("p", sr.ground, CRANK, **COIL, k=f)),
    "RSDA.c": ("x", lambda f: sr.RSDA("p", sr.ground, CRANK, **COIL, k=1.0, c=f)),
    "RSDA.torque": ("t", lambda f: sr.RSDA("p", sr.ground, CRANK, **COIL, k=1.0, torque=f)),
    "Drag.c": ("x", lambda f: sr.Drag("p", B, f)),
    "PointForce.force": ("t", lambda f: sr.PointForce("p", B, (f, 1, 0))),
    "PointForce.factor": ("t", lambda f: sr.PointForce("p", B, X, factor=f)),
    "Torque.torque": ("t", lambda f: sr.Torque("p", BLOCK, (0, f, 0))),
    "Torque.factor": ("t", lambda f: sr.Torque("p", BLOCK, X, factor=f)),
    "RoadTyre.road": ("x", lambda f: sr.RoadTyre("p", C, k=9.0, c=0.1, radius=0.9, road=f)),
    "RoadTyre.bump": ("t", lambda f: sr.RoadTyre("p", C, k=9.0, c=0.1, radius=0.9, bump=f)),
    "BrushTyre.road": (
        "x", lambda f: sr.BrushTyre("p", C, radius=0.9, k=9.0, c_kappa=9.0, c_alpha=9.0, mu=1.0, axis=X, road=f)
    ),
    "FialaTyre.road": (
        "x", lambda f: sr.FialaTyre("p", C, radius=0.9, k=9.0, c_kappa=9.0, c_alpha=9.0, mu_max=1.0, axis=X, road=f)
    ),
    "TmeasyTyre.road": ("x", lambda f: sr.TmeasyTyre("p", C, radius=0.9, k=9.0, axis=X, road=f, **TMEASY)),
    "MagicFormulaTyre.road": ("x", lambda f: sr.MagicFormulaTyre("p", C, coefficients=COEFFICIENTS, axis=X, road=f)),
    "Force.value": ("v", lambda f: sr.Force("p", A, B, value=f)),
    "Torque.value": ("v", lambda f: sr.Torque("p", "pin", value=f)),
    "Tendon.value": ("x", lambda f: sr.Tendon("p", [A, B, C], value=f)),
    "Input.value": ("t", lambda f: sr.Input("p", f)),
    "FormulaCoupler.value": ("pin.angle", lambda f: sr.FormulaCoupler("p", "slide", value=f)),
    "StateVariable.rate": ("pin.rate", lambda f: sr.StateVariable("p", rate=f, initial=0.1)),
    "FirstOrderLag.input": ("pin.rate", lambda f: sr.FirstOrderLag("p", input=f, time=0.1)),
    "TransferFunction.input": (
        "pin.rate", lambda f: sr.TransferFunction("p", input=f, numerator=[1, 2], denominator=[1, 3, 2]),
    ),
    "StateSpaceBlock.inputs": (
        "pin.rate", lambda f: sr.StateSpaceBlock("p", A=[[-1.0]], B=[[1.0]], C=[[1.0]], inputs=[f]),
    ),
    "PID.input": ("pin.rate", lambda f: sr.PID("p", input=f, kp=1.0, ki=2.0, kd=0.1, filter=0.05)),
    "DCMotor.voltage": ("t", lambda f: sr.DCMotor("p", "pin", f, resistance=1.0, inductance=0.1, constant=0.05)),
    "MuscleActivation.input": ("pin.rate", lambda f: sr.MuscleActivation("p", input=f)),
    "Muscle.activation": (
        "t", lambda f: sr.Muscle("p", [A, B, C], activation=f, peak_force=1.0, optimal_length=1.5),
    ),
    "point": ("t", lambda f: sr.TSDA("p", sr.ground.point(0.1, 0, f), B, k=1.0, length=0.3)),
}  # fmt: skip
# Take formulas by the class that PID does; of positions only, see `forces/test_along.py`
ELSEWHERE = {"HydraulicCylinder.input", "PneumaticChamber.input", "Force.along"}
# Laws of shafts, see `forces/test_driveline.py`
ELSEWHERE |= {f"{kind}.torque" for kind in ("Shaft", "Differential", "Brake")}
ELSEWHERE |= {f"Engine.{field}" for field in ("throttle", "full_load", "motoring")} | {
    "ElectricMotor.command"
}
ELSEWHERE |= {"Transmission.ratio", "Transmission.engagement"}
ELSEWHERE |= {"TorqueConverter.capacity", "TorqueConverter.torque_ratio"}


def system(part: Any) -> sr.System:
    drivers, forces, joints = (
        [part] if isinstance(part, kind) else [] for kind in (sr.model.Driver, sr.model.Force, sr.model.Joint)
    )
    return sr.System(sr.Model("m", [CRANK, BLOCK, WHEEL], [*JOINTS, *joints], forces, drivers=drivers))


def values(of: sr.System) -> np.ndarray:
    """Forces and constraints at two states and times."""
    found = []
    for seed in (1, 2):
        move = np.random.default_rng(seed)
        q, v = of.q0 + 0.1 * move.standard_normal(of.nq), move.standard_normal(of.nq)
        found += [of.Q(q, v, 0.3 * seed), of.Phi(q, 0.3 * seed)]
    return np.concatenate(found)


def in_python(text: str, variable: str) -> Any:
    """The text as a Python function, whose names are those of `sarrus.functions`."""
    argument, u = ("o", f"o['{variable}']") if "." in variable else (variable, variable)
    return eval(
        f"lambda {argument}: {as_text(text, u)}", {n: getattr(functions, n) for n in functions.__all__}
    )


def as_text(text: str, variable: str) -> str:
    return re.sub(r"\bu\b", variable, text)


def of_outputs(place: str) -> bool:
    return place in OF_OUTPUTS or "." in PLACES[place][0]


def test_every_function_and_every_place_is_here() -> None:
    assert CALLS.keys() == {*FUNCTIONS}
    assert {*FUNCTIONS} <= {*functions.__all__}
    laws = {
        f"{type(part).__name__}.{field.name}"
        for own in of_every_kind().model.sections().values()
        for part in own
        for field in fields(part)
        if (measure := measures_of(part).get(field.name)) and (measure.over != "1" or measure.outputs)
    }
    assert laws == {*PLACES, *ELSEWHERE} - {"point"}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("place", PLACES)
def test_a_text_a_file_and_a_function_are_the_same(place: str, tmp_path: Path) -> None:
    variable, make = PLACES[place]
    every = EVERY if of_outputs(place) and place != "Drag.c" else FEW
    text = system(make(as_text(every, variable)))
    text.model.save(tmp_path / "m.yaml")
    again = sr.System(sr.load(tmp_path / "m.yaml"))
    assert np.array_equal(again.b, text.b)
    expected = values(text)
    assert np.array_equal(values(again), expected)
    assert not np.array_equal(expected, values(system(make("0.01")))) or place == "Input.value"
    assert values(system(make(in_python(every, variable)))) == pytest.approx(expected, rel=1e-12, abs=1e-14)


@pytest.mark.parametrize("place", [place for place in PLACES if place == "Drag.c" or not of_outputs(place)])
def test_a_function_that_laws_of_one_variable_do_not_have_is_refused(place: str) -> None:
    variable, make = PLACES[place]
    for law in (as_text(CALLS["atan2"], variable), in_python(CALLS["atan2"], variable)):
        with pytest.raises(
            sr.ModelError, match=r'"p.*": .* cannot be used as a formula: .* cannot use atan2. Choose'
        ):
            system(make(law))


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("jump", JUMPS)
def test_jumps_are_those_of_the_time_or_refused(place: str, jump: str) -> None:
    variable, make = PLACES[place]
    laws = (as_text(jump, variable), in_python(jump, variable))
    if of_outputs(place) and variable != "t":
        for law in laws:
            with pytest.raises(
                sr.ModelError, match=r'"p": \w+ has .*which jumps with .*(Use tanh|use a periodic table)'
            ):
                system(make(law))
        return
    text, function = (system(make(law)) for law in laws)
    assert values(text) == pytest.approx(values(function), rel=1e-14)
    (moved,) = numbers_in_jumps(text.model)
    assert written_numbers(text.model)[moved] == 0.1
    with pytest.raises(
        sr.SarrusError, match=f"{moved} moves a jump of a law, .* no derivative here. Leave it out"
    ):
        Parameters(text, [moved]).along(np.ones(1))


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    ("continuous", "law"),
    [
        (True, lambda v: functions.abs(v - 1) * v + functions.ramp(-v)),
        (True, lambda x: functions.max(x, 1) + functions.min(2 * x, 3, ) + functions.step(x, 0, 0, 1, 1)),
        (True, lambda t, v: v * functions.sign(t - 0.1)),
        (True, lambda v: v * functions.sign(v)),
        (True, lambda v: functions.step(v) * v**2),
        (True, lambda x, v: functions.step(v) * (v * x)),
        (True, lambda x, v: v * (functions.step(v) * x)),
        (True, lambda v: functions.step(v) / 2 * v),
        (True, lambda x, v: functions.step(v) / x * v),
        (True, lambda v: functions.step(2 * v) * v),
        (True, lambda v: functions.step(v) * functions.sin(v)),
        (True, lambda k, v: functions.step(v) * (v / k)),
        (False, lambda v: functions.step(v) * (v / v**2)),
        (False, lambda v: functions.step(v) * (1 / v) * v),
        (False, lambda v: functions.step(v) / v * v),
        (False, lambda x, v: functions.step(v) * v + functions.step(v) * x),
        (False, lambda k, v: functions.step(k * v) * v),
        (False, lambda v: functions.step(v) * functions.cos(v)),
        (False, lambda v: functions.sin(functions.step(v))),
        (False, lambda x, v: functions.step(x - v)),
        (False, lambda k, t: functions.step(t - k)),
    ],
)  # fmt: skip
def test_functions_that_jump_differ_from_those_with_corners(continuous: bool, law: Any) -> None:
    force = sr.Force("p", A, B, value=law, parameters={"k": 0.1})
    if continuous:
        assert np.all(np.isfinite(values(system(force))))
        return
    with pytest.raises(sr.ModelError, match="jumps with the motion or a parameter and not only with t"):
        system(force)


def test_jumps_of_long_functions_are_found_in_one_pass() -> None:
    """Nodes that are read grow as the terms do, and not as their square."""

    class Counted(list[Node]):
        read = 0

        def __getitem__(self, n: Any) -> Any:
            Counted.read += 1
            return super().__getitem__(n)

    reads = []
    for terms in (100, 400):
        graph = Graph()
        x = graph.input("signal", 0)
        result = sum((functions.max(x - k, 0) + functions.abs(x + k) * k for k in range(terms)), x)
        graph.nodes, Counted.read = Counted(graph.nodes), 0
        refuse_recorded_jumps(result, "value")
        reads.append(Counted.read)
    assert 0 < reads[1] < 4.5 * reads[0]


def test_gradients_leave_out_what_moves_a_jump(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(FILE)
    run = sr.simulate(sr.System(sr.load(tmp_path / "m.yaml")), until=1.0, store="steps")
    found = sr.sensitivity(run, "block.x")
    assert "push.factor.1" in found.names
    assert "push.factor.2" not in found.names
    assert sr.sensitivity(run, "block.x", ["push.factor.1"])["push.factor.1"] == pytest.approx(0.18)
    with pytest.raises(sr.SarrusError, match=r"push.factor.2 moves a jump of a law"):
        sr.sensitivity(run, "block.x", ["start"])


FILE = """
name: m
parameters: {start: 0.4 s}
bodies:
  block: {mass: 1, inertia: [1, 1, 1]}
forces:
  push: {type: point_force, point: {body: block, at: [0, 0, 0]}, force: [1, 0, 0], factor: 3*step(t - start)}
"""
