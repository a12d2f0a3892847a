"""Sensors of a description, as outputs by name: ``imu_gyro.x``, ``elbow_position``."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from ...euler import A
from ...model.errors import ModelError
from ...model.geometry import rotation
from ...model.geometry.points import GROUND
from ...model.show import counted
from ...outputs import Level, Output, Outputs, provides
from ...system import System
from .description import Description, Sensor
from .interaction import BETWEEN, TOUCH, beyond, interaction, masses_of, touch
from .tree.coordinates import Coordinates

XYZ, EULER = ("x", "y", "z"), ("e0", "e1", "e2", "e3")


class Kind(NamedTuple):
    """A kind of sensor: its unit, its components (none of a number), what it depends on, and its value."""

    unit: str
    axes: tuple[str, ...]
    level: Level
    value: Callable[[Outputs, Sensor], Array]


def _axes(o: Any, own: Sensor) -> Any:
    """The axes of a frame as columns, in global axes."""
    return A(o.vector("q", own.link)[3:]) @ own.axes


def _axis(n: int) -> Kind:
    return Kind("1", XYZ, Level.POSITION, lambda o, own: _axes(o, own)[:, n])


def _quaternion(o: Any, own: Sensor) -> Any:
    return rotation.product(o.vector("q", own.link)[3:], rotation.parameters(own.axes))


def _velocity(o: Any, own: Sensor) -> Any:
    return o.velocity(own.link, own.point)


def _acceleration(o: Any, own: Sensor) -> Any:
    """Of a frame at rest, it is upwards."""
    return o.acceleration(own.link, own.point) - np.array(o.system.model.gravity)


def _joint(o: Any, own: Sensor) -> Any:
    return own.factor * o.joint(own.joint) + own.start


KINDS: dict[str, Kind] = {
    "framepos": Kind("m", XYZ, Level.POSITION, lambda o, own: o.position(own.link, own.point)),
    "framequat": Kind("1", EULER, Level.POSITION, _quaternion),
    "framexaxis": _axis(0),
    "frameyaxis": _axis(1),
    "framezaxis": _axis(2),
    "framelinvel": Kind("m/s", XYZ, Level.VELOCITY, _velocity),
    "frameangvel": Kind("rad/s", XYZ, Level.VELOCITY, lambda o, own: o.angular_velocity(own.link)),
    "framelinacc": Kind("m/s²", XYZ, Level.ACCELERATION, _acceleration),
    "frameangacc": Kind("rad/s²", XYZ, Level.ACCELERATION, lambda o, own: o.angular_acceleration(own.link)),
    "velocimeter": Kind("m/s", XYZ, Level.VELOCITY, lambda o, own: _velocity(o, own) @ _axes(o, own)),
    "gyro": Kind("rad/s", XYZ, Level.VELOCITY, lambda o, own: o.angular_velocity(own.link) @ _axes(o, own)),
    "accelerometer": Kind(
        "m/s²", XYZ, Level.ACCELERATION, lambda o, own: _acceleration(o, own) @ _axes(o, own)
    ),
    "force": Kind("N", XYZ, Level.ACCELERATION, lambda o, own: interaction(o, own)[0]),
    "torque": Kind("N m", XYZ, Level.ACCELERATION, lambda o, own: interaction(o, own)[1]),
    TOUCH: Kind("N", (), Level.VELOCITY, touch),
    "jointpos": Kind("", (), Level.POSITION, _joint),
    "jointvel": Kind("", (), Level.VELOCITY, lambda o, own: own.factor * o.joint(own.joint, rate=True)),
}


def resolved(description: Description, coordinates: Coordinates) -> dict[str, Sensor]:
    """Return the sensors in the model: on bodies in body axes, and of coordinates of joints; others are left out."""
    sensors = {name: _of_links(description, one, coordinates) for name, one in description.sensors.items()}
    found = {name: _resolved(sensor, coordinates) for name, sensor in sensors.items()}
    return {name: sensor for name, sensor in found.items() if sensor is not None}


def _of_links(description: Description, sensor: Sensor, coordinates: Coordinates) -> Sensor:
    """Return a sensor of forces with the links that it is of."""
    if sensor.kind in BETWEEN:
        links = beyond(description, sensor.link)
        return sensor._replace(links=links, masses=masses_of(description, links, coordinates.links))
    return sensor._replace(links=(sensor.link,)) if sensor.kind == TOUCH else sensor


def unresolved(description: Description, found: Mapping[str, Sensor]) -> list[str]:
    """Return the note on sensors that the model cannot have."""
    n = len(description.sensors) - len(found)
    text = "{n} sensor[s] on the ground, or of joints that do not move by themselves: left out"
    return [counted(text, n)] if n else []


def _resolved(sensor: Sensor, coordinates: Coordinates) -> Sensor | None:
    if not sensor.joint:
        link = coordinates.links.get(sensor.link)
        if link is None or link.body.name == GROUND:
            return None
        s, axes = link.place.global_point(sensor.point), link.place.A @ sensor.axes
        return sensor._replace(link=link.body.name, point=s, axes=axes)
    if sensor.joint not in coordinates.edges:
        return None
    try:
        coordinate = coordinates.find(sensor.joint, "")
    except ModelError:  # it is part of a joint that has no such coordinate
        return None
    return sensor._replace(joint=coordinate.name, factor=coordinate.sign)


@provides
def sensors(system: System, part: str | None) -> Iterator[Output]:
    """Outputs of the sensors of a robot."""
    for name, sensor in getattr(system.model, "sensors", {}).items():
        if part in (None, name):
            kind = KINDS[sensor.kind]
            for n, axis in enumerate(kind.axes or ("",)):
                record = partial(_record, kind, sensor, n if kind.axes else None)
                yield Output(f"{name}.{axis}".rstrip("."), kind.unit or _unit(sensor), record, kind.level)


def _unit(sensor: Sensor) -> str:
    unit = "rad" if sensor.joint.partition(".")[2].startswith("angle") else "m"
    return f"{unit}/s" if sensor.kind == "jointvel" else unit


def _record(kind: Kind, sensor: Sensor, n: int | None, o: Any) -> Any:
    found = kind.value(o, sensor)
    return found if n is None else found[n]
