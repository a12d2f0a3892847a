"""Calls of public functions and classes with one or two arguments that no caller should give."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

import sarrus as sr
from sarrus import mechanisms

from . import oracle

NAN = float("nan")
HOSTILE: tuple[Callable[[], Any], ...] = tuple(
    (lambda value=value: value)  # type: ignore[misc]
    for value in (
        NAN, float("inf"), -float("inf"), None, "", "text", "rod.mass", -1, 0, 1, 2.5, 1e308, -1e-320,
        10**400, True, b"x", 1j, [],
        [NAN], [None], ["a"], [1, [2]], {}, {"a": 1}, {1: 2}, {"rod.mass": NAN}, set(), range(3), (0, 0, 0),
        (1, 2, 3), (0, 0, NAN),
        np.zeros(3), np.zeros((2, 2)), np.zeros((0,)), np.array(["a"]), np.array(NAN), np.full(21, NAN),
        np.ones(14), np.zeros(21, dtype=object),
        np.int64(3), Path("nowhere"), lambda *a: None, lambda *a: NAN, lambda *a: "x", object, sr,
        sr.ground, sr.HHT, sr.HHT(), Ellipsis,
    )
)  # fmt: skip


@cache
def crank() -> tuple[Any, Any, Any, Any]:
    """A model, its system, its assembly and a short run."""
    model = sr.load(mechanisms.path("slider_crank"))
    system = sr.System(model)
    start = sr.assemble(system)
    return model, system, start, sr.simulate(system, start, until=0.02)


@cache
def functions() -> dict[str, tuple[Any, dict[str, Any]]]:
    """Good calls of functions: a name, the function, and its arguments."""
    model, system, start, run = crank()
    body, rod = sr.Body("a", mass=1.0, inertia=(1, 1, 1)), model.bodies[0]
    point = sr.Point(rod, (0, 0, 0))
    study = {"responses": {"x": "slider.x"}, "analysis": sr.Simulation(until=0.01), "workers": 1}
    found: dict[str, tuple[Any, dict[str, Any]]] = {
        "System": (sr.System, {"model": model}),
        "assemble": (sr.assemble, {"system": system, "q": None, "v": None, "t": 0.0, "tolerance": 1e-12,
        "iterations": 20, "seed": 0,
                                   "fixed": (), "metric": "unit", "restarts": 1, "rates": None}),
        "simulate": (sr.simulate, {"system": system, "start": start, "until": 0.02, "events": [], "t_eval": None,
        "limits": sr.Limits(time=3.0, steps=50), "method": sr.HHT(rtol=1e-6, atol=1e-8, max_step=1.0)}),
        "kinematics": (sr.kinematics, {"system": system, "times": [0.0, 0.01], "q": None, "time_limit": 3.0}),
        "equilibrium": (sr.equilibrium, {"system": system, "q": None, "t": 0.0, "iterations": 20}),
        "linearize": (sr.linearize, {"system": system, "q": start.q, "v": None, "t": 0.0, "outputs": ["slider.x"]}),
        "modes": (sr.modes, {"system": system, "q": start.q, "v": None}),
        "mobility": (sr.mobility, {"system": system, "q": None, "t": 0.0, "tolerance": 1e-8}),
        "inverse_dynamics": (sr.inverse_dynamics, {"system": system, "run": run}),
        "parse_expression": (sr.parse_expression, {"text": "2*x + sin(t)", "variables": ("x", "t")}),
        "load": (sr.load, {"path": mechanisms.path("slider_crank"), "parameters": {}}),
        "load_any": (sr.load_any, {"path": mechanisms.path("slider_crank")}),
        "load_urdf": (sr.load_urdf, {"path": "none.urdf", "base": "fixed", "gravity": (0, 0, -9.81),
        "lock": (), "q0": {}}),
        "load_run": (sr.load_run, {"path": "nowhere"}),
        "resume": (sr.resume, {"path": "nowhere"}),
        "open_study": (sr.open_study, {"folder": "nowhere"}),
        "study": (sr.study, {"model": model, "parameters": {"rod.mass": [1.0]}, **study}),
        "Trajectory.joint": (run.joint, {"name": model.joints[0].name}),
        "Simulation": (sr.Simulation, {"until": 0.02}),
        "Body": (sr.Body, {"name": "a", "mass": 1.0, "inertia": (1, 1, 1), "position": (0, 0, 0),
        "orientation": (1, 0, 0, 0),
                           "velocity": (0, 0, 0), "angular_velocity": (0, 0, 0), "center_of_mass": None}),
        "Revolute": (sr.Revolute, {"name": "p", "body_i": sr.ground, "body_j": body, "point": (0, 0, 0),
        "axis": (0, 0, 1)}),
        "Spherical": (sr.Spherical, {"name": "p", "body_i": sr.ground, "body_j": body, "point": (0, 0, 0)}),
        "TSDA": (sr.TSDA, {"name": "s", "point_i": sr.Point(sr.ground, (0, 0, 2)), "point_j": sr.Point(body,
        (0, 0, 0)), "k": 10.0,
                           "length": 1.0, "c": 0.1, "force": 0.0}),
        "Point": (sr.Point, {"body": rod, "coordinates": (0, 0, 0)}),
        "Frame": (sr.Frame, {"point": point, "x": (1, 0, 0), "z": (0, 0, 1)}),
        "AxisAngle": (sr.AxisAngle, {"axis": (0, 0, 1), "angle": 1.0}),
        "Curve.table": (sr.Curve.table, {"pairs": [(0, 0), (1, 1), (2, 4)]}),
        "HHT": (sr.HHT, {"alpha": -0.1}),
        "GeneralizedAlpha": (sr.GeneralizedAlpha, {}),
        "Radau": (sr.Radau, {}),
        "Event": (sr.Event, {"function": lambda t, q, v: 1.0}),
        "Final": (sr.Final, {"of": "slider.x", "name": "a"}),
    }  # fmt: skip
    return {name: call for name, call in found.items() if _fits(*call)}


def _fits(function: Any, arguments: dict[str, Any]) -> bool:
    try:
        inspect.signature(function).bind(**arguments)
    except TypeError as error:
        raise RuntimeError(f"{function}: {error}") from None
    return True


def random_call(random: Random) -> tuple[str, dict[str, Any], Callable[[Path], list[str]]]:
    """A name, arguments of which one or two are hostile, and what makes the call and uses the result."""
    name = random.choice([*functions()])
    function, good = functions()[name]
    arguments = dict(good)
    known = [
        key
        for key in inspect.signature(function).parameters
        if key not in ("progress", "save", "folder", "executor", "overwrite")
    ]
    for key in random.sample(known, min(len(known), random.choice((1, 1, 2)))):
        arguments[key] = random.choice(HOSTILE)()
    if name in ("simulate", "kinematics"):
        arguments["time_limit"] = 3.0

    def run(folder: Path) -> list[str]:
        return list(_used(function(**arguments)))

    return name, arguments, run


def _used(result: Any) -> list[str]:
    """Print the result, put parts into a model, and look for what cannot be."""
    repr(result)
    str(result)
    parts: dict[str, Any] = (
        {"bodies": [result]}
        if isinstance(result, sr.Body)
        else {"bodies": [sr.Body("a", mass=1.0, inertia=(1, 1, 1))]}
    )
    if isinstance(result, sr.Revolute | sr.Spherical):
        parts["joints"] = [result]
    if isinstance(result, sr.TSDA):
        parts["forces"] = [result]
    if isinstance(result, sr.Body | sr.Revolute | sr.Spherical | sr.TSDA):
        model = sr.Model("m", **parts)
        return list(oracle.nonsense(model))
    if isinstance(result, sr.HHT | sr.GeneralizedAlpha | sr.Radau):
        result = sr.simulate(
            crank()[1], crank()[2], until=0.01, method=result, limits=sr.Limits(time=3.0, steps=50)
        )
    if isinstance(result, sr.Event):
        result = sr.simulate(
            crank()[1], crank()[2], until=0.01, events=result, limits=sr.Limits(time=3.0, steps=50)
        )
    if getattr(result, "success", False) and not _finite(getattr(result, "q", 0.0)):
        return [f"{type(result).__name__} says success, but q is not finite"]
    return []


def _finite(value: Any) -> bool:
    return bool(np.isfinite(np.asarray(value, dtype=float)).all())
