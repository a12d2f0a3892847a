"""What Exudyn is told of a model, in plain numbers, so that both codes simulate the same; and how it is run."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import sarrus as sr
from sarrus import euler
from sarrus.model.bodies.inertia import inertia_entries
from sarrus.model.geometry.pose import GROUND_POSE

FIXED = {  # along and about f, g, h of a frame on the first body
    sr.Revolute: (1, 1, 1, 1, 1, 0),
    sr.Translational: (1, 1, 0, 1, 1, 1),
    sr.PointOnLine: (1, 1, 0, 0, 0, 0),
    sr.PointOnPlane: (0, 0, 1, 0, 0, 0),
}
Place = tuple[str, tuple[float, float, float]]  # a body and a point in its axes


class Told:
    """A model from a start; `points` are wanted at the end, `others` are forces in the words of `exudyn_run.py`."""

    def __init__(
        self, system: sr.System, start: sr.Assembly, points: Sequence[Place], others: Sequence[dict[str, Any]]
    ) -> None:
        model = system.model
        self._poses = {"ground": GROUND_POSE, **{body.name: body.pose() for body in model.bodies}}
        states = zip(model.bodies, start.q.reshape(-1, 7), start.v.reshape(-1, 7), strict=True)
        hidden = {other["name"] for other in others}
        self.data = {
            "gravity": list(model.gravity),
            "bodies": [_body(body, q, v) for body, q, v in states],
            "joints": [self._joint(joint) for joint in model.joints],
            "forces": [self._force(force) for force in model.forces if force.name not in hidden],
            "points": [{"body": body, "at": list(at)} for body, at in points],
        }
        self.data["forces"] += [{k: v for k, v in other.items() if k != "name"} for other in others]

    def _joint(self, joint: Any) -> dict[str, Any]:
        if type(joint) in FIXED:
            i, j = joint.frames(self._poses)
            return {"type": "generic", "i": _frame(i), "j": _frame(j), "fixed": FIXED[type(joint)]}
        if isinstance(joint, sr.Spherical):
            return self._pair(joint, "spherical", ())
        assert type(joint) is sr.Distance, joint
        return self._pair(joint, "distance", ("length",))

    def _force(self, force: Any) -> dict[str, Any]:
        if isinstance(force, sr.TSDA):
            return self._pair(force, "tsda", ("k", "c", "length"))
        if isinstance(force, sr.Torque):
            return {"type": "torque", "body": force.body.name, "torque": list(force.torque)}
        (primitive,) = force.primitives(self._poses)
        point = {"body": primitive.bodies[0], "at": list(primitive.values[0])}
        if isinstance(force, sr.Tyre):
            return {"type": "tyre", "point": point, "k": force.k, "c": force.c, "radius": force.radius}
        assert type(force) is sr.PointForce, force
        assert force.axes == "global", force
        return {"type": "force", "point": point, "force": list(force.force)}

    def _pair(self, part: Any, kind: str, names: Sequence[str]) -> dict[str, Any]:
        """A part between two points, with its numbers."""
        (primitive,) = part.primitives(self._poses)
        (one, other), values = (
            primitive.bodies,
            dict(zip(primitive.element.fields, primitive.values, strict=True)),
        )
        places = {
            "i": {"body": one, "at": list(values["s_i"])},
            "j": {"body": other, "at": list(values["s_j"])},
        }
        return {"type": kind, **places, **{name: float(values[name]) for name in names}}


def _body(body: sr.Body, q: Any, v: Any) -> dict[str, Any]:
    """Mass and state, ω = 2 E ṗ."""
    assert body.center_of_mass is None
    xx, yy, zz, xy, xz, yz = inertia_entries(body.inertia)
    return {
        "name": body.name,
        "mass": body.mass,
        "inertia": [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]],
        "position": q[:3].tolist(),
        "axes": np.array(euler.A(q[3:]), dtype=float).tolist(),
        "velocity": v[:3].tolist(),
        "angular_velocity": (2 * np.array(euler.E(q[3:]), dtype=float) @ v[3:]).tolist(),
    }


def _frame(frame: Any) -> dict[str, Any]:
    axes = np.column_stack([frame.f, frame.g, frame.h]).astype(float)
    return {"body": frame.body, "at": [float(x) for x in frame.s], "axes": axes.tolist()}


class Exudyn:
    """A process that simulates one model."""

    def __init__(self, python: str, told: Told, program: str = "exudyn_run.py") -> None:
        command = [python, "-W", "ignore", str(Path(__file__).parent / program)]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self._say(told.data)

    def _say(self, what: Any) -> None:
        assert self._process.stdin
        print(json.dumps(what), file=self._process.stdin, flush=True)

    def run(self, **wanted: Any) -> dict[str, Any]:
        """Steps, end time [s], linear solver "dense" or "sparse"; perhaps numbers of Newton's method."""
        self._say(wanted)
        assert self._process.stdout
        for line in self._process.stdout:
            if line.startswith("RESULT "):
                found: dict[str, Any] = json.loads(line[7:])
                return found
        raise RuntimeError("Exudyn ended without a result")

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin
        self._process.stdin.close()
        self._process.wait()
