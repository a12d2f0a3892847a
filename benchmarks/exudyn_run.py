"""Exudyn in its own process: reads a model, then runs to be done, one JSON object a line; see `exudyn_told.py`.

Spatial bodies with Euler parameters and generic joints, as in Sarrus; generalized-α with rho_inf = 0.9 and modified
Newton, one thread, nothing written; the module without range checks. A run is answered by a line that begins with
RESULT: processor seconds of the solver, the points wanted at the end, the accelerations of all bodies there.
"""

from __future__ import annotations

import json
import sys
import time
import warnings
from typing import Any

import numpy as np

warnings.simplefilter("ignore")
sys.exudynFast = True  # type: ignore[attr-defined]

import exudyn as exu  # noqa: E402  after the quick module is asked for
from exudyn import symbolic  # noqa: E402
from exudyn import utilities as eu  # noqa: E402

RHO = 0.9
SOLVERS = {"dense": exu.LinearSolverType.EXUdense, "sparse": exu.LinearSolverType.EigenSparse}


class Build:
    """The model in Exudyn."""

    spent = 0.0  # processor seconds in the functions of tyres

    def __init__(self, told: dict[str, Any]) -> None:
        self.container = exu.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.bodies = {"ground": self.mbs.CreateGround()}
        self.alive: list[Any] = []  # symbolic functions must outlive the run
        for body in told["bodies"]:
            self.bodies[body["name"]] = self.body(body, told["gravity"])
        for part in (*told["joints"], *told["forces"]):
            getattr(self, part["type"])(**{key: value for key, value in part.items() if key != "type"})
        self.mbs.Assemble()

    def body(self, told: dict[str, Any], gravity: list[float]) -> Any:
        return self.mbs.CreateRigidBody(
            referencePosition=told["position"],
            referenceRotationMatrix=np.array(told["axes"]),
            initialVelocity=told["velocity"],
            initialAngularVelocity=told["angular_velocity"],
            inertia=eu.RigidBodyInertia(mass=told["mass"], inertiaTensor=np.array(told["inertia"])),
            nodeType=exu.NodeType.RotationEulerParameters,
            gravity=gravity,
        )

    def point(self, told: dict[str, Any], turning: bool = False) -> Any:
        kind = eu.MarkerBodyRigid if turning else eu.MarkerBodyPosition
        return self.mbs.AddMarker(kind(bodyNumber=self.bodies[told["body"]], localPosition=told["at"]))

    def generic(self, i: dict[str, Any], j: dict[str, Any], fixed: list[int]) -> None:
        markers = [self.point(i, True), self.point(j, True)]
        turned = {"rotationMarker0": np.array(i["axes"]), "rotationMarker1": np.array(j["axes"])}
        self.mbs.AddObject(eu.GenericJoint(markerNumbers=markers, constrainedAxes=fixed, **turned))

    def spherical(self, i: dict[str, Any], j: dict[str, Any]) -> None:
        self.mbs.AddObject(
            eu.SphericalJoint(markerNumbers=[self.point(i), self.point(j)], constrainedAxes=[1, 1, 1])
        )

    def distance(self, i: dict[str, Any], j: dict[str, Any], length: float) -> None:
        self.mbs.AddObject(
            eu.DistanceConstraint(markerNumbers=[self.point(i), self.point(j)], distance=length)
        )

    def tsda(self, i: dict[str, Any], j: dict[str, Any], k: float, c: float, length: float) -> None:
        law = {"stiffness": k, "damping": c, "referenceLength": length}
        self.mbs.AddObject(eu.SpringDamper(markerNumbers=[self.point(i), self.point(j)], **law))

    def tyre(self, point: dict[str, Any], k: float, c: float, radius: float) -> None:
        law = {"stiffness": [0, 0, k], "damping": [0, 0, c], "offset": [0, 0, radius]}
        flat = self.point({"body": "ground", "at": [0, 0, 0]})
        self.mbs.AddObject(eu.CartesianSpringDamper(markerNumbers=[flat, self.point(point)], **law))

    def force(self, point: dict[str, Any], force: list[float]) -> None:
        self.mbs.AddLoad(eu.Force(markerNumber=self.point(point), loadVector=force))

    def torque(self, body: str, torque: list[float]) -> None:
        at = {"body": body, "at": [0, 0, 0]}
        self.mbs.AddLoad(eu.Torque(markerNumber=self.point(at, True), loadVector=torque))

    def bump(
        self, point: dict[str, Any], k: float, c: float, height: float, begins: float, takes: float
    ) -> None:
        """k h + c ḣ upwards with h = height sin⁴ π s, s = (t - begins) / takes between 0 and 1."""
        pi, slope = np.pi, 4 * np.pi * height / takes

        def load(mbs, t, load):  # type: ignore[no-untyped-def]  # the names that Exudyn wants
            s = (t - begins) / takes
            yes, no = symbolic.Real(1.0), symbolic.Real(0.0)
            inside = symbolic.IfThenElse(s * (1.0 - s) > 0.0, yes, no)
            sine, cosine = symbolic.sin(pi * s), symbolic.cos(pi * s)
            lift = inside * sine * sine * sine * (k * height * sine + c * slope * cosine)
            return symbolic.Vector([0.0, 0.0, lift])

        function = eu.CreateSymbolicUserFunction(
            self.mbs, load, "loadVectorUserFunction", itemTypeName="LoadForceVector"
        )
        self.alive.append(function)
        self.mbs.AddLoad(
            eu.Force(markerNumber=self.point(point), loadVector=[0, 0, 1], loadVectorUserFunction=function)
        )


def run(told: dict[str, Any], wanted: dict[str, Any], kind: type[Build] = Build) -> dict[str, Any]:
    """One simulation from the start; what it took, and where it ends."""
    build = kind(told)
    settings = exu.SimulationSettings()
    time_integration = settings.timeIntegration
    time_integration.numberOfSteps, time_integration.endTime = wanted["steps"], wanted["until"]
    time_integration.generalizedAlpha.spectralRadius = RHO
    time_integration.newton.useModifiedNewton = True
    for name, value in wanted.get("newton", {}).items():
        setattr(time_integration.newton, name, value)
    time_integration.verboseMode = 0
    settings.solutionSettings.writeSolutionToFile = False
    settings.linearSolver.solverType = SOLVERS[wanted["solver"]]
    settings.parallel.numberOfThreads = 1
    began = time.process_time()
    build.mbs.SolveDynamic(settings)
    taken = time.process_time() - began

    def output(kind: Any, body: str, at: list[float]) -> list[float]:
        now = exu.ConfigurationType.Current
        return list(build.mbs.GetObjectOutputBody(build.bodies[body], kind, at, now))

    kinds = exu.OutputVariableType
    end = [output(kinds.Position, point["body"], point["at"]) for point in told["points"]]
    bodies = [body["name"] for body in told["bodies"]]
    accelerations = [output(kinds.Acceleration, body, [0, 0, 0]) for body in bodies]
    found = {"seconds": taken, "steps": wanted["steps"], "end": end, "accelerations": accelerations}
    return found | {"spent": build.spent}


def main(kind: type[Build] = Build) -> None:
    told = json.loads(sys.stdin.readline())
    for line in sys.stdin:
        try:
            answer = run(told, json.loads(line), kind)
        except (RuntimeError, ValueError) as trouble:
            answer = {"trouble": str(trouble)}
        print("RESULT", json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
