"""One run of Exudyn in its own process: ``python exudyn_run.py PROBLEM STEPS`` prints processor seconds and end.

Spatial bodies with Euler parameters and generic joints, as in Sarrus; generalized-α with rho_inf = 0.9 and modified
Newton, one thread, nothing written.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any

import exudyn as exu
import numpy as np
from exudyn import utilities as eu

RHO = 0.9
REVOLUTE, ON_LINE, ON_PLANE = [1, 1, 1, 1, 1, 0], [1, 1, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0]


class Build:
    """Spatial bodies, joints about z and loads."""

    def __init__(self) -> None:
        self.container = exu.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.ground = self.mbs.CreateGround()

    def body(
        self,
        inertia: list[float],
        at: list[float],
        angle: float,
        v: list[float],
        w: float,
        weight: float = 0.0,
    ) -> Any:
        return self.mbs.CreateRigidBody(
            referencePosition=at,
            referenceRotationMatrix=eu.RotationMatrixZ(angle),
            initialVelocity=v,
            initialAngularVelocity=[0, 0, w],
            inertia=eu.RigidBodyInertia(mass=1.0, inertiaTensor=np.diag(inertia)),
            nodeType=exu.NodeType.RotationEulerParameters,
            gravity=[0, -weight, 0],
        )

    def joint(self, one: Any, other: Any, at: list[float], axes: list[int]) -> None:
        self.mbs.CreateGenericJoint(
            bodyNumbers=[one, other], position=at, constrainedAxes=axes, useGlobalFrame=True, show=False
        )


UPRIGHT, LYING = [1 / 12, 1 / 1200, 1 / 12], [1 / 1200, 1 / 12, 1 / 12]
Made = tuple[Any, Any, list[float], float]


def four_bars(n: int) -> Made:
    """N four-bar mechanisms; the point B_0 after 10 s."""
    b = Build()
    uprights = [b.body(UPRIGHT, [i, 0.5, 0], 0.0, [0.5, 0, 0], -1.0, 9.81) for i in range(n + 1)]
    for i, upright in enumerate(uprights):
        b.joint(b.ground, upright, [i, 0, 0], REVOLUTE)
    for i in range(n):
        coupler = b.body(LYING, [i + 0.5, 1.0, 0], 0.0, [1.0, 0, 0], 0.0, 9.81)
        b.joint(uprights[i], coupler, [i, 1, 0], REVOLUTE)
        b.joint(uprights[i + 1], coupler, [i + 1, 1, 0], ON_LINE)
    return b.mbs, uprights[0], [0.0, 0.5, 0.0], 10.0


def slider_crank() -> Made:
    """The slider-crank of SUNDIALS; the slider after 10 s."""
    b, p = Build(), -np.pi / 6
    crank = b.body([1, 1, 1], [0, 0, 0], np.pi / 2, [0, 0, 0], 0.0)
    rod = b.body([2, 2, 2], [np.cos(p), 0, 0], p, [0, 0, 0], 0.0)
    b.joint(b.ground, crank, [0, 0, 0], REVOLUTE)
    b.joint(crank, rod, [0, 0.5, 0], REVOLUTE)
    b.joint(b.ground, rod, [np.cos(p), 0, 0], ON_PLANE)
    b.mbs.CreateSpringDamper(
        bodyNumbers=[crank, rod],
        localPosition0=[0.25, 0, 0],
        localPosition1=[-0.5, 0, 0],
        referenceLength=1.0,
        stiffness=1.0,
        damping=1.0,
    )
    b.mbs.CreateForce(bodyNumber=rod, loadVector=[1.0, 0, 0], localPosition=[1.0, 0, 0])
    return b.mbs, rod, [0.0, 0.0, 0.0], 10.0


def chain(n: int) -> Made:
    """A chain of rods that falls from the horizontal; its first rod's end after 0.5 s."""
    b = Build()
    before, first = b.ground, None
    for i in range(n):
        rod = b.body(LYING, [i + 0.5, 0, 0], 0.0, [0, 0, 0], 0.0, 9.81)
        b.joint(before, rod, [i, 0, 0], REVOLUTE)
        before, first = rod, first or rod
    return b.mbs, first, [0.5, 0.0, 0.0], 0.5


def main(problem: str, steps: int) -> None:
    name, _, size = problem.partition(":")
    made = {"four_bars": four_bars, "slider_crank": slider_crank, "chain": chain}[name]
    mbs, body, point, until = made(*([int(size)] if size else []))
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = steps, until
    settings.timeIntegration.generalizedAlpha.spectralRadius = RHO
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.timeIntegration.verboseMode = 0
    settings.solutionSettings.writeSolutionToFile = False
    settings.linearSolver.solverType = (
        exu.LinearSolverType.EigenSparse if size and int(size) > 3 else exu.LinearSolverType.EXUdense
    )
    settings.parallel.numberOfThreads = 1
    began = time.process_time()
    mbs.SolveDynamic(settings)
    taken = time.process_time() - began
    kind, now = exu.OutputVariableType.Position, exu.ConfigurationType.Current
    end = mbs.GetObjectOutputBody(body, kind, point, now)
    print("RESULT", json.dumps({"seconds": taken, "steps": steps, "end": list(end[:2])}))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
