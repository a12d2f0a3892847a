"""Force and torque between a link and its parent, as a force-torque sensor measures them, and forces of contacts.

Both are those that accelerate the link and all that hangs on it, less the forces of contacts and of joints that close
loops. All other forces between the two, such as of motors and springs, are counted as those of the joint, as in MuJoCo.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np

from ...algebra import Array
from ...elements import Element, Force, InertiaElement, Primitive, SphereContact
from ...elements.inertia import tensor
from ...euler import A, rotate
from ...outputs.recording import members_of
from .description import Description, Inertia, Sensor, combined
from .tree.carried import LinkPlace
from .zone import is_met

Ends: TypeAlias = tuple[str, str]  # the links of a part, i and j
BETWEEN, TOUCH = ("force", "torque"), "touch"  # kinds of sensors


def beyond(description: Description, link: str) -> frozenset[str]:
    """Return a link and all that hangs on it."""
    links = {link}
    for edge in description.edges:  # each after that of its parent
        links |= {edge.child} if edge.parent in links else set()
    return frozenset(links)


def masses_of(
    description: Description, links: frozenset[str], carried: Mapping[str, LinkPlace]
) -> tuple[tuple[str, Inertia | None], ...]:
    """Return the bodies that some links are part of, with None for whole bodies, else the inertial of these links."""
    on: dict[str, list[str]] = {}
    for name, link in carried.items():
        if name in description.links and description.links[name].inertial is not None:
            on.setdefault(link.body.name, []).append(name)
    masses = []
    for body, every in on.items():
        some = [name for name in every if name in links]
        parts = [_inertial(description, name).seen_from(carried[name].place) for name in some]
        if some:
            masses.append((body, None if len(some) == len(every) else combined(parts)))
    return tuple(masses)


def acted(sensor: Sensor, ends: Mapping[str, Ends]) -> Sensor:
    """Return a sensor with the contacts and loops that act on its links, and the end on which each does."""
    acting = []
    for part, links in ends.items():
        inside = [link in sensor.links for link in links]
        if inside[0] != inside[1]:
            acting.append((part, "_i" if inside[0] else ""))
    return sensor._replace(acting=tuple(acting))


def interaction(o: Any, sensor: Sensor) -> tuple[Array, Array]:
    """Return the force on a link and the torque about the sensor, in the axes of the sensor."""
    at, gravity = o.position(sensor.link, sensor.point), np.array(o.system.model.gravity)
    force, torque = np.zeros(3), np.zeros(3)
    for body, inertial in sensor.masses:
        mass, center, J = inertial or _of_element(o, body)
        axes, spin = A(o.vector("q", body)[3:]), o.angular_velocity_body(body)
        change = mass * (o.acceleration(body, center) - gravity)
        turning = J @ o.angular_acceleration_body(body) + np.cross(spin, J @ spin)
        force = force + change
        torque = torque + axes @ turning + np.cross(o.position(body, center) - at, change)
    for part, side in sensor.acting:
        load, moment, point = _load(o, part, side)
        force, torque = force - load, torque - moment - np.cross(point - at, load)
    axes = A(o.vector("q", sensor.link)[3:]) @ sensor.axes
    return force @ axes, torque @ axes


def touch(o: Any, sensor: Sensor) -> Any:
    """Return the sum of normal forces of contacts from which the outward normal meets the zone."""
    total: Any = o.constant(0.0)
    center, axes = o.position(sensor.link, sensor.point), A(o.vector("q", sensor.link)[3:]) @ sensor.axes
    for part, side in sensor.acting:
        p, k = _element(o, part, SphereContact)
        contact, x = o.element(p, k, "b"), o.local(p, k, "q")
        normal = rotate(x.p_j, contact.n_j)
        place = x.r_i + rotate(x.p_i, contact.s_i) - (contact.radius - contact.depth(x) / 2) * normal
        start, ray = (vector @ axes for vector in (place - center, normal * (-1 if side else 1)))
        total = total + o.constant(is_met(sensor.zone, start, ray) * 1.0) * o(f"{part}.normal_force")
    return total


def _inertial(description: Description, link: str) -> Inertia:
    inertial = description.links[link].inertial
    assert inertial is not None
    return inertial


def _of_element(o: Any, body: str) -> Inertia:
    """Return the inertial of a body, whose numbers derivatives can be taken by."""
    element = o.element(*_element(o, body, InertiaElement), "b")
    return Inertia(element.mass, getattr(element, "center", np.zeros(3)), tensor(element.inertia))


def _load(o: Any, part: str, side: str) -> tuple[Array, Array, Array]:
    """Return the force of a contact, spring or joint on one of its bodies, and the torque about a point, with it."""
    p, k = _element(o, part, Primitive, Force)
    if p.kind.rows:
        end = side.removeprefix("_")
        return o.force(part, end), o.torque(part, end), o.point_of_joint(part, end or "j")
    names = ([f"{part}.{word}{side}.{axis}" for axis in "xyz"] for word in ("force", "torque"))
    force, torque = (np.array([o(name) for name in three]) for three in names)
    x = o.local(p, k, "q")
    return force, torque, x.r_i if side else x.r_j


def _element(o: Any, part: str, *kinds: type[Element]) -> tuple[Any, int]:
    """Return the first element of a part that is of one of some kinds."""
    return next(
        (p, k) for p in o.system.populations if issubclass(p.kind, kinds) for k in members_of(p, part)
    )
