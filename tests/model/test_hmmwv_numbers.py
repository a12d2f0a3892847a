"""The HMMWV described by hardpoints against numbers of the same vehicle described by points of its bodies."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.analyses.test_simulation import rigid_velocity

import sarrus as sr

FILE = Path(__file__).parent.parent / "reference" / "hmmwv_numbers.json"


@cache
def reference() -> dict[str, Any]:
    return dict(json.loads(FILE.read_text()))


def moved(system: sr.System) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities off the constraints, the same for each body whatever the order of bodies is."""
    q, v = system.q0.copy(), np.zeros(system.nq)
    for n, name in enumerate(sorted(system.bodies)):
        own = system.coordinates_of(name)
        q[own] += 1e-2 * np.sin(np.arange(1, 8) * (n + 1))
        q[own][3:] /= np.linalg.norm(q[own][3:])
        v[own] = np.cos(np.arange(1, 8) * (n + 2))
    return q, v


def numbers_of(system: sr.System) -> dict[str, Any]:
    """What does not depend on the order of parts, nor on the directions of axes within joints."""
    q, v = moved(system)
    places = {name: system.coordinates_of(name) for name in sorted(system.bodies)}
    inertia, force = system.M(q) @ v, system.Q(q, v)
    joints = sorted(one.name for one in system.model.joints)
    constraints = system.Phi(q)
    rolling = rigid_velocity(system, np.array([5.0, 0.0, -0.3]), np.array([0.2, 0.1, 0.05]))
    method = sr.Radau(rtol=1e-10, atol=1e-10)
    run = sr.simulate(system, sr.assemble(system, v=rolling), until=0.05, t_eval=[0, 0.05], method=method)
    lifted = system.q0.copy()
    lifted[2::7] += 1e-3
    rest = sr.equilibrium(system, lifted)
    modes = np.linalg.eigvals(sr.linearize(system, rest).A)
    return {
        "start": {name: system.q0[own].tolist() for name, own in places.items()},
        "Mv": {name: inertia[own].tolist() for name, own in places.items()},
        "Q": {name: force[own].tolist() for name, own in places.items()},
        "Phi": {name: float(np.linalg.norm(constraints[system.rows[name]])) for name in joints},
        "acceleration": {name: run[name].acceleration[0].tolist() for name in places},
        "reaction": {name: run.reaction(name).force[0].tolist() for name in joints},
        "end": {name: run[name].position[-1].tolist() for name in places},
        "equilibrium": {name: rest.q[own].tolist() for name, own in places.items()},
        "eigenvalues": sorted([x.real, abs(x.imag)] for x in modes),
    }


TOLERANCES = {  # absolute: of numbers of the order of 1, of forces of up to 1e4 N, and of a run to 1e-10
    "start": 2e-14, "Mv": 1e-9, "Q": 1e-8, "Phi": 1e-13, "acceleration": 1e-7, "reaction": 1e-4,
    "end": 1e-9, "equilibrium": 1e-10, "eigenvalues": 1e-4,
}  # fmt: skip


@cache
def found() -> dict[str, Any]:
    return numbers_of(sr.System(sr.load("hmmwv")))


@pytest.mark.parametrize("name", TOLERANCES)
def test_it_is_the_same_vehicle(name: str) -> None:
    wanted, own = reference()[name], found()[name]
    if isinstance(wanted, dict):
        assert own.keys() == wanted.keys()
        wanted, own = ([one[key] for key in sorted(wanted)] for one in (wanted, own))
    assert np.array(own) == pytest.approx(np.array(wanted), abs=TOLERANCES[name], rel=0)


MOVED = (
    "front_upper_ball.z",
    "front_tie_outer.y",
    "rear_lower_front.z",
    "rear_spring_top.y",
    "front_wheel.y",
    "knuckle_inboard",
)


def vehicle(**given: float) -> sr.System:
    return sr.System(sr.load("hmmwv", parameters=given))


def rest_of(system: sr.System) -> np.ndarray:
    """Heights and the angle of an arm in the static equilibrium."""
    rest = sr.equilibrium(system)
    return np.array([rest["chassis.z"], rest["knuckle_rear_right.z"], rest["rev_UCA_front_left.angle"]])


def end_of(system: sr.System, **options: Any) -> Any:
    """A run from the assembled start, which follows the hardpoints, at 3 m/s."""
    rolling = rigid_velocity(system, np.array([3.0, 0.0, -0.2]), np.array([0.1, 0.2, 0.05]))
    method = sr.Radau(rtol=1e-9, atol=1e-9)
    return sr.simulate(system, lambda own: sr.assemble(own, v=rolling), until=0.2, method=method, **options)


def differences(of: Any, name: str, h: float) -> Any:
    """Fourth-order differences of vehicles that are loaded with another value of a parameter."""
    value = sr.load("hmmwv").parameters[name]
    near = [of(vehicle(**{name: value + n * h})) for n in (2, 1, -1, -2)]
    return (-near[0] + 8 * near[1] - 8 * near[2] + near[3]) / (12 * h)


@pytest.mark.parametrize("name", MOVED)
def test_derivatives_of_the_equilibrium_by_hardpoints(name: str) -> None:
    rest = sr.equilibrium(vehicle())
    outputs = ["chassis.z", "knuckle_rear_right.z", "rev_UCA_front_left.angle"]
    own = np.array([sr.sensitivity(rest, one, [name])[name] for one in outputs])
    assert own == pytest.approx(differences(rest_of, name, 2e-4), abs=2e-8)
    assert np.any(abs(own) > 1e-4)


@pytest.mark.parametrize("name", MOVED[:3])
def test_derivatives_of_a_run_by_hardpoints(name: str) -> None:
    run = end_of(vehicle(), store="steps")
    own = sr.sensitivity(run, sr.Final("chassis.z"), [name])[name]
    found = differences(lambda system: float(end_of(system)["chassis.z"][-1]), name, 1e-4)
    assert own == pytest.approx(found, abs=1e-6)
    assert abs(own) > 1e-5
