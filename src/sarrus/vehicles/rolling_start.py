"""The start of a manoeuvre: a vehicle at its static equilibrium that rolls straight ahead with a uniform speed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..algebra import Array
from ..analyses.dynamics.sampled.readings import readings_at
from ..analyses.equilibria.statics import equilibrium
from ..analyses.position.assembly import assemble
from ..euler import A, E
from ..model import Model, SarrusError
from ..model.announcement import collecting
from ..model.checks.arguments import NumberIn, checked_by
from ..model.states.driveline import RATE, Shaft, TorqueConverter, Transmission
from ..model.states.input import with_input_values
from ..model.tyres.rolling_tyre import SPIN, RollingTyre
from ..results import Assembly, Equilibrium, State
from ..system import System

ITERATIONS, SAME = 50, 1e-14  # of the spin, which changes the rolling radius; relative change of the last one


@checked_by(speed=NumberIn("m/s"))
def rolling_start(system: System, speed: float, inputs: Mapping[str, Any] | None = None) -> Assembly:
    """Return the state in which a vehicle rolls straight ahead at its static equilibrium.

    All bodies move with the same velocity, horizontally and perpendicularly to the mean spin axis of the tyres, and
    each wheel with a rolling tyre turns about its spin axis by V_x/R_e, without longitudinal slip, as a body or as the
    spin of its tyre. Shafts turn without slip of the clutches and torque converters between them and the wheels. Other
    states, such as those of controllers and of deflections of tyres, are those of the equilibrium: a run begins with a
    small transient.

    Parameters
    ----------
    system : System
        With rolling tyres, such as `MagicFormulaTyre`. The values of its own inputs must allow an equilibrium at rest
    speed : V [m/s], negative for backwards
    inputs : those of the run that starts here, as of `simulate`; ratios of gears have their values at the start

    Raises
    ------
    SarrusError
        If the model has no rolling tyres or no such input, or no equilibrium is found on all tyres.
    """
    tyres = [one for one in system.model.forces if isinstance(one, RollingTyre)]
    if not tyres:
        message = "it has no rolling tyres. Add one for each wheel, such as sr.BrushTyre."
        raise SarrusError(f"{system.name}: {message}")
    with collecting():  # of states that are arbitrary at rest: the vehicle leaves it at once
        rest = equilibrium(system)
    if not rest.success:
        raise SarrusError(f"{rest.message}. Correct the model, or its inputs, so that it can stand.")
    if lifted := [tyre.name for tyre in tyres if not rest[f"{tyre.name}.load"] > 0]:
        message = f"in the equilibrium that was found, {', '.join(lifted)} do not touch the road"
        raise SarrusError(f"{system.name}: {message}. Press all tyres on the road in the initial position.")
    wheels = [(tyre, *_axis(system, rest, tyre)) for tyre in tyres]
    across = np.sum([axis for _, _, axis in wheels], axis=0)
    ahead = np.cross(across, (0.0, 0.0, 1.0))
    velocity = speed * ahead / np.linalg.norm(ahead)
    v = system.v0.copy() if rest.v is None else rest.v.copy()
    for body in system.bodies:
        v[system.coordinates_of(body)] = (*velocity, 0.0, 0.0, 0.0, 0.0)
    for tyre, body, axis in wheels:
        forward = np.cross(axis, (0.0, 0.0, 1.0))
        spin = _spin(rest, tyre, float(velocity @ forward / np.linalg.norm(forward)))
        if (state := system.states.get(f"{tyre.name}.{SPIN}")) is not None:
            v[state.place] = spin
        else:
            own = system.coordinates_of(body)
            v[own][3:] = 0.5 * E(rest.q[own][3:]).T @ (spin * axis)
    return assemble(system, rest.q, _without_slip(system, rest, v, inputs or {}), t=rest.t)


def _without_slip(system: System, rest: Equilibrium, v: Array, inputs: Mapping[str, Any]) -> Array:
    """The velocities with those of shafts that turn without slip in clutches and converters, from the wheels on."""
    left = {one.name for one in system.model.forces if isinstance(one, Shaft)}
    couplings = [one for one in system.model.forces if isinstance(one, Transmission | TorqueConverter)]
    model = with_input_values(system.model, inputs)
    system = _engaged(system, model) if couplings else system
    while ready := [one for one in couplings if _ends(one)[0] in left and _ends(one)[1] not in left]:
        part = ready[0]
        driving, driven = _ends(part)
        left.remove(driving)
        read = readings_at(system, State(rest.t, rest.q, v, rest.memory, rest.revolutions))
        torque = read[f"{part.name}.value"]
        ratio = read[f"{part.name}.output"] / torque if isinstance(part, Transmission) and torque else 1.0
        v[system.states[f"{driving}.{RATE}"].place] = ratio * read[f"{driven}.{RATE}"]
    return v


def _engaged(system: System, model: Model) -> System:
    """The system of a model with closed clutches, whose torques show the ratios of the gears."""
    forces = [
        replace(one, engagement=1.0) if isinstance(one, Transmission) and one.engagement != 1.0 else one
        for one in model.forces
    ]
    same = all(one is other for one, other in zip(forces, system.model.forces, strict=True))
    return system if same else System(replace(model, forces=forces))


def _ends(part: Transmission | TorqueConverter) -> tuple[str, str]:
    """The shafts on the side of the engine and on that of the wheels."""
    return (part.input, part.output) if isinstance(part, Transmission) else (part.pump, part.turbine)


def _axis(system: System, rest: Equilibrium, tyre: RollingTyre) -> tuple[str, Array]:
    """The body of a wheel, and its spin axis at rest, to the left (3,)."""
    primitive = next(iter(tyre.primitives(system.model.design_poses())))
    body, local = primitive.bodies[1], np.asarray(primitive.values[1], dtype=float)
    return body, np.asarray(A(rest.q[system.coordinates_of(body)][3:]) @ local)


def _spin(rest: Equilibrium, tyre: RollingTyre, speed: float) -> float:
    """Ω with R_e(Ω) Ω = V_x [rad/s]; only the spin changes the load and the rolling radius."""
    law, gamma = tyre.law(), float(rest[f"{tyre.name}.inclination"])
    loaded = float(law.unloaded_radius)
    for _ in range(ITERATIONS):  # the second step is the last one of all laws but 6.2
        last, loaded = loaded, loaded + law.depth(loaded, 0.0, gamma) - rest[f"{tyre.name}.compression"]
        if abs(loaded - last) <= SAME * loaded:
            break
    spin = float(speed / loaded)
    for _ in range(ITERATIONS):
        load = law.vertical_force(law.depth(loaded, spin, gamma), 0.0, spin, tyre.rounding)
        last, spin = spin, float(speed / law.rolling_radius(loaded, load, spin))
        if abs(spin - last) <= SAME * abs(spin):
            break
    return spin
