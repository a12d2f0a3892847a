"""The car in Exudyn, in its own process: `exudyn_run.py` with tyres, anti-roll bars and a steered rack in Python.

A tyre evaluates the formulas of Sarrus on plain numbers, once for each state that Exudyn asks about: the force and the
torque on the upright are loads; the two deflections and the spin are velocities of an ODE2 object of unit masses, as
in Sarrus, since the steps are of first order with ODE1 objects.
"""

from __future__ import annotations

import math
import sys
import time
from pathlib import Path
from typing import Any

import exudyn_run
import numpy as np
from exudyn_run import Build, eu

sys.path.insert(0, str(Path(__file__).parent.parent / "src"))

from sarrus.elements.element import Pair
from sarrus.elements.forces.tyres import MagicFormula61
from sarrus.elements.forces.tyres.contact import tyre_element
from sarrus.elements.forces.tyres.rotor import Rotor
from sarrus.elements.forces.tyres.spinning import SpinningTyre
from sarrus.euler import A, E

NO_TURN = np.zeros(4)


class Car(Build):
    """The model, and the processor seconds that its tyres have taken."""

    def __init__(self, told: dict[str, Any]) -> None:
        self.places = {body["name"]: slice(7 * k, 7 * k + 7) for k, body in enumerate(told["bodies"])}
        self.tyres = 0
        self.spent = 0.0
        super().__init__(told)
        kind = exudyn_run.exu.ConfigurationType.Reference
        self.reference = np.array(self.mbs.systemData.GetODE2Coordinates(kind))

    def coordinates(self, body: str) -> Any:
        """Place and Euler parameters now."""
        own = self.places[body]
        return self.reference[own] + self.mbs.systemData.GetODE2Coordinates()[own]

    def rolling_tyre(
        self, body: str, coefficients: dict[str, float], values: list[Any], inertia: float, start: list[float]
    ) -> None:
        """A Magic Formula tyre with its spin, on a flat road."""
        kind: Any = tyre_element(SpinningTyre, MagicFormula61, tuple(coefficients), "flat")
        numbers = [np.array(value) if isinstance(value, list) else value for value in values]
        tyre, rotor = kind(*numbers, inertia, *coefficients.values()), Rotor(inertia, numbers[1])
        first = 7 * len(self.places) + 3 * self.tyres
        own = slice(first, first + 3)
        self.tyres += 1
        known: dict[str, Any] = {"at": None}

        def found(states: Any = None) -> Any:
            q, v = self.coordinates(body), np.array(self.mbs.systemData.GetODE2Coordinates_t())
            states, v = np.array(v[own] if states is None else states), v[self.places[body]]
            at = (q.tobytes(), v.tobytes(), states.tobytes())
            if known["at"] != at:
                began = time.process_time()
                x = Pair(np.zeros(3), NO_TURN, q[:3], q[3:])
                rates = Pair(states, NO_TURN, v[:3], v[3:])
                block, _, F, turning = tyre.Q(x, rates, 0.0)
                turning = turning + rotor.Q(x, rates, 0.0)[3]
                known.update(at=at, rates=list(block), force=list(F), torque=list(E(q[3:]) @ turning / 2))
                self.spent += time.process_time() - began
            return known

        def rates(mbs: Any, t: float, item: int, q: Any, q_t: Any) -> Any:
            return found(q_t)["rates"]

        def force(mbs: Any, t: float, load: Any) -> Any:
            return found()["force"]

        def torque(mbs: Any, t: float, load: Any) -> Any:
            return found()["torque"]

        node = self.mbs.AddNode(
            eu.NodeGenericODE2(
                referenceCoordinates=[0.0] * 3, initialCoordinates=[0.0] * 3, initialCoordinates_t=start,
                numberOfODE2Coordinates=3,
            )
        )  # fmt: skip
        self.mbs.AddObject(
            eu.ObjectGenericODE2(nodeNumbers=[node], massMatrix=np.eye(3), forceUserFunction=rates)
        )
        marker = self.point({"body": body, "at": [0, 0, 0]}, True)
        self.mbs.AddLoad(eu.Force(markerNumber=marker, loadVector=[0, 0, 1], loadVectorUserFunction=force))
        self.mbs.AddLoad(eu.Torque(markerNumber=marker, loadVector=[0, 0, 1], loadVectorUserFunction=torque))

    def bar(self, left: dict[str, Any], right: dict[str, Any], k: float) -> None:
        """Torques -k (θ - θ of the other side) about two pivots."""
        for one, other in ((left, right), (right, left)):

            def law(
                mbs: Any, t: float, item: int, u: Any, turned: Any, *rest: Any, other: Any = other
            ) -> Any:
                return [0.0] * 5 + [k * (turned[2] - self.angle(other))]

            self.connector(one, law)

    def angle(self, joint: dict[str, Any]) -> float:
        """θ of a revolute joint."""
        i, j = (
            A(self.coordinates(end["body"])[3:]) @ np.array(end["axes"]) for end in (joint["i"], joint["j"])
        )
        return math.atan2(i[:, 1] @ j[:, 0], i[:, 0] @ j[:, 0])

    def steered(
        self, joint: dict[str, Any], k: float, c: float, radius: float, amplitude: float, period: float
    ) -> None:
        """-k (x + radius δ) - c v along a rack, δ a sine of the time."""

        def law(mbs: Any, t: float, item: int, u: Any, turned: Any, v: Any, *rest: Any) -> Any:
            steer = amplitude * math.sin(2 * math.pi * t / period)
            return [0.0, 0.0, k * (u[2] + radius * steer) + c * v[2], 0.0, 0.0, 0.0]

        self.connector(joint, law)

    def connector(self, joint: dict[str, Any], law: Any) -> None:
        """A spring between the frames of a joint, forces and torques along the first ones."""
        i, j = joint["i"], joint["j"]
        turned = {"rotationMarker0": np.array(i["axes"]), "rotationMarker1": np.array(j["axes"])}
        self.mbs.AddObject(
            eu.RigidBodySpringDamper(
                markerNumbers=[self.point(i, True), self.point(j, True)],
                springForceTorqueUserFunction=law, stiffness=np.eye(6), damping=np.eye(6), **turned,
            )
        )  # fmt: skip


if __name__ == "__main__":
    exudyn_run.main(Car)
