"""All forces of a description: those of its joints, tendons and actuators, and lifted weights."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

from ....model import AngleStop, DisplacementStop, Input, PointForce
from ....model.errors import ModelError
from ....model.expression.functions import CONSTANTS
from ....model.forces import Force
from ....model.geometry.motion import Slide, Turn
from ....model.geometry.solid import GROUND
from ....model.quantity import triple
from ....model.show import quote
from ....model.states.input import OWN
from ..description import Description, Edge, Stop, legal
from ..joints import Hinge
from ..tree.carried import Carried, part_on_bodies
from ..tree.coordinates import Coordinates
from ..tree.merge import Merged
from .actuators import PARAMETERS, actuator_forces
from .dynamics import forces_of
from .tendons import tendon_force

ROUNDING = 1e-4  # [rad, m] less than the depth of usual loads


def forces(
    description: Description,
    merged: Merged,
    hinges: Mapping[str, Hinge],
    coordinates: Coordinates,
    controls: Mapping[str, Any],
    taken: set[str],
) -> tuple[Force, ...]:
    """Return the forces on motions that are left, each with a name that is free; hinges are by edge."""
    found = [*_of_joints(description, merged, hinges), *_lifts(description, coordinates.links)]
    for name, given in description.tendons.items():
        force = tendon_force(name, given, coordinates)
        found += [force] if force is not None else []
    inputs = list[Input]()
    for name, actuator in description.actuators.items():
        control = Input(input_name(name, taken), controls.get(name, 0.0))
        taken = taken | {control.name}
        acting = [*actuator_forces(name, actuator, coordinates, control)]
        inputs, found = inputs + [control] * bool(acting), found + acting
    taken = {*taken}
    names = [legal([force.name], taken, "_force")[force.name] for force in found]  # two may have the same
    renamed = (replace(force, name=name) for force, name in zip(found, names, strict=True))
    return (*inputs, *map(part_on_bodies, renamed))


def input_name(actuator: str, taken: set[str]) -> str:
    """Return the name of an actuator's input, which formulas can use; one with another meaning ends with _control."""
    name = actuator.replace("-", "_")
    used = taken | {*OWN, *CONSTANTS, *PARAMETERS}
    return legal([name], used, "_control")[name]


def _of_joints(description: Description, merged: Merged, hinges: Mapping[str, Hinge]) -> Iterator[Force]:
    for edge in merged.edges:
        for motion in edge.motions:
            hinge, name = hinges[edge.name], motion.name
            with located(description, edge):
                if name in description.dynamics:
                    yield from forces_of(hinge, motion, description.dynamics[name])
                if name in description.stops and isinstance(motion, Turn | Slide):
                    yield stop_of(hinge, motion, description.stops[name])


def _lifts(description: Description, links: Mapping[str, Carried]) -> Iterator[Force]:
    """Yield the force against gravity on each moving link that has one."""
    for name, part in description.lifted.items():
        inertial = description.links[name].inertial
        if part and inertial is not None and name in links and links[name].body.name != GROUND:
            lift = triple(-part * inertial.mass * np.array(description.gravity))
            yield PointForce(f"{name}_gravcomp", links[name].point(*triple(inertial.center)), lift)


@contextmanager
def located(description: Description, edge: Edge) -> Iterator[None]:
    """Name the joint and its place in messages."""
    try:
        yield
    except ModelError as error:
        part = error.part or f"joint {quote(edge.name)}"
        where = description.where(edge.line)
        raise ModelError(error.message, part=part, field=error.field, where=where) from None


def stop_of(hinge: Hinge, motion: Turn | Slide, given: Stop) -> Force:
    """Return the stop of a motion, named after it."""
    turn = isinstance(motion, Turn)
    kind: Any = AngleStop if turn else DisplacementStop
    i, j = hinge.frames(motion.point if isinstance(motion, Turn) else np.zeros(3), motion.axis)
    stop: Force = kind(f"{motion.name}_stop", frame_i=i, frame_j=j, rounding=ROUNDING, **given._asdict())
    return stop
