"""A model as drawn parts: all that a picture, a page or a film of it is made of."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, count
from math import pi
from typing import Any

import numpy as np

from ...algebra import Array
from ...model import Model, ModelError
from ...model.announcement import announce
from ...model.bodies.mesh_file import MissingReaderError
from ...model.coordinates import slice_of
from ...model.expansion.blueprint import Blueprint, blueprint
from ...model.geometry.points import GROUND
from ...model.joints.couplings import Coupling
from ...model.quantity import SMALLEST_LENGTH
from ...model.show import quote
from ...model.tyres.rolling_tyre import SPIN
from ..meshes import Facets, MeshError
from ..meshes.mesh import Mesh, along, joined, upright
from ..meshes.read import given_meshes
from ..meshes.solids import ball, coil, disc, rim, ring, rod, spiral, wheel
from .anchors import ORIGIN, Anchor, anchors, masses, points_of
from .body import Outline, body_meshes
from .coupling import Hold, coupling_parts, hub, wheels
from .frame import MovingFrame, lifted, spun
from .joint import RAILS, DrawingScale, joint_parts, mount
from .part import DAMPER, DARK, LOOK, PALETTE, RUBBER, SPRING, STEEL, Part, Span, body_frame, place_of
from .road import Road, roads_of

ROLLING = ("brush_tyre", "fiala_tyre", "magic_formula_tyre", "tmeasy_tyre")
TYRES = ("tyre", "road_tyre", *ROLLING)
START = np.zeros(1)
Look = Iterator[Part | Span]
Z = np.array([0.0, 0.0, 1.0])
DESCRIPTIONS = {
    "tsda": "spring and damper",
    "rsda": "torsion spring",
    "sphere_contact": "contact",
    **dict.fromkeys(("road_tyre", *ROLLING), "tyre"),
}


@dataclass(frozen=True, eq=False)
class Sketch:
    """A model as meshes that move with its bodies.

    Attributes
    ----------
    name : of the model
    bodies : names; body number n has the coordinates ``q[7 (n - 1) : 7 n]``
    parts, spans : what is drawn
    colors : of the bodies
    centers : of mass, in body axes (nb, 3) [m]
    up : unit vector against gravity; z if there is none
    size : extent of the drawing [m]
    unit : thickness of a rod [m]
    low : height of the lowest point, along ``up`` [m]
    floor : height of the lowest point of roads [m], None without tyres
    weighs : whether there is gravity
    given : whether some shapes are given, not made from joints and points
    notes : messages about what could not be drawn as given
    moving : frames of roads that move and of wheels whose spin is a state; their numbers are behind those of the bodies
    """

    name: str
    bodies: tuple[str, ...]
    parts: tuple[Part, ...]
    spans: tuple[Span, ...]
    colors: tuple[str, ...]
    centers: Array
    up: Array
    size: float
    unit: float
    low: float
    floor: float | None
    weighs: bool
    given: bool = False
    notes: tuple[str, ...] = ()
    moving: tuple[MovingFrame, ...] = ()

    def coordinates(self, t: Array, q: Array, v: Array) -> Array:
        """The coordinates of all that moves, seven each, at times t (n,), of q and v (n, nq)."""
        bodies = q[:, : slice_of(len(self.bodies)).start]
        return np.column_stack([bodies, *(frame.coordinates(t, q, v) for frame in self.moving)])


def sketch(model: Model, positions: Array | None = None, times: Array = START) -> Sketch:
    """Draw a model.

    Parameters
    ----------
    model : Model
    positions : (n, nq) positions that rails shall reach, and above which the ground lies; by default the initial one
    times : at which roads that move are above the ground [s]

    Raises
    ------
    ModelError
        If anything is wrong in the model, or if a mesh cannot be read.
    """
    plan = blueprint(model)
    return _Drawing(
        model, plan, plan.q[None] if positions is None or not len(positions) else positions, times
    ).sketch()


class _Drawing:
    def __init__(self, model: Model, plan: Blueprint, positions: Array, times: Array) -> None:
        self.model, self.plan, self.positions, self.times = model, plan, positions, times
        self.joints, self.forces = (anchors(model, plan, section) for section in ("joints", "forces"))
        self.masses = masses(plan)
        self.notes: list[str] = []
        self.moving: list[MovingFrame] = []
        self.holds = {anchor.name: self._hold(anchor) for anchor in self.joints}
        self.wheels = wheels(model.joints, self.holds)
        self.given = self._given()
        gravity = np.array(model.gravity, dtype=float)
        weight = np.linalg.norm(gravity)
        self.up = -gravity / weight if weight else np.array([0.0, 0.0, 1.0])
        self.size, self.low = self._extent()
        self.unit = self._unit()
        self.scale = DrawingScale(self.unit, self.size, self.up, dict(self._displacements()))

    def sketch(self) -> Sketch:
        roads = [*roads_of(self.plan, self._tyres(), self.positions)]
        drawn = [
            *self._bodies(),
            *self._joints(),
            *self._couplings(),
            *self._forces(),
            *self._roads(roads),
        ]
        return Sketch(
            self.model.name,
            self.plan.bodies,
            tuple(one for one in drawn if isinstance(one, Part)),
            tuple(one for one in drawn if isinstance(one, Span)),
            tuple(_color(n) for n in range(1, len(self.plan.bodies) + 1)),
            np.array([self.masses[n + 1][2] for n in range(len(self.plan.bodies))]),
            self.up,
            self.size,
            self.unit,
            self.low,
            min((road.lowest(self.up, self.times) for road in roads), default=None),
            any(self.model.gravity),
            bool(self.given),
            tuple(self.notes),
            tuple(self.moving),
        )

    def _given(self) -> dict[str, list[Facets]]:
        """The meshes that are given, by body. A file of the model's own must be there, one of a robot's should be."""
        by_body: dict[str, list[Facets]] = {}
        with_shape = {body.name for body in self.model.bodies if body.shape is not None}
        for look in self.model.looks():
            try:
                by_body.setdefault(look.body, []).extend(given_meshes(look))
            except MeshError as error:
                if look.body in with_shape:
                    part, where = f"body {quote(look.body)}", self.model.where(look.body)
                    raise ModelError(str(error), part=part, field="shape", where=where) from None
                self.notes.append(str(error))
                if isinstance(error, MissingReaderError):
                    announce([str(error)])
        return {body: meshes for body, meshes in by_body.items() if meshes}

    def _bodies(self) -> Iterator[Part]:
        for number, name in enumerate((GROUND, *self.plan.bodies)):
            description = f"body, {self.masses[number][0]:.4g} kg" if number else "it does not move"
            color = _color(number) if number else STEEL
            for piece in self.given.get(name, ()):
                yield Part(name, "body", description, number, piece.mesh, piece.color or color)
            if number and name not in self.given:
                outline = self._outline(number)
                if number in self.wheels and len(outline.points) == 1:
                    yield Part(name, "body", description, number, hub(self.wheels[number], self.scale), color)
                    continue
                for mesh, opacity in body_meshes(outline, self.unit, self.size):
                    yield Part(name, "body", description, number, mesh, color, opacity)

    def _outline(self, number: int) -> Outline:
        points: list[Array] = []
        hinges: list[Array | None] = []
        guide = None
        for anchor in (*self.joints, *(f for f in self.forces if len({*f.bodies}) == 2)):
            for side, body in enumerate(anchor.bodies):
                if body == number:
                    points.append(anchor.points[side])
                    hinges.append(anchor.axes[side][:, 2] if anchor.kind == "revolute" else None)
                    if anchor.kind == "translational" and side:
                        guide = anchor.points[side], anchor.axes[side]
        return Outline(points, hinges, *self.masses[number], guide)

    def _joints(self) -> Iterator[Part | Span]:
        for anchor in self.joints:
            if not self._hidden(anchor):
                yield from joint_parts(_long(anchor, self._distance(anchor)), self.scale)

    def _hidden(self, anchor: Anchor) -> bool:
        """Whether both bodies of a joint have shapes of their own, which show the joint too."""
        names = (GROUND, *self.plan.bodies)
        return all(names[body] in self.given for body in anchor.bodies)

    def _couplings(self) -> Iterator[Part]:
        for part in self.model.joints:
            if isinstance(part, Coupling):
                yield from coupling_parts(part, self.holds, self.scale)

    def _hold(self, anchor: Anchor) -> Hold:
        """Where a joint holds its second body, or its first if the second is the ground."""
        side = 1 if anchor.bodies[1] else 0
        body, point = anchor.bodies[side], anchor.points[side]
        origin, axes = body_frame(self.plan.q, body)

        def local(mesh: Mesh) -> Mesh:
            return mesh.moved(-origin).moved(np.zeros(3), axes.T)

        return Hold(anchor.name, body, origin + axes @ point, axes @ anchor.axes[side], local)

    def _forces(self) -> Iterator[Part | Span]:
        for anchor in self.forces:
            length = max(self._distance(anchor), self.unit)
            axle = self._axle(anchor)
            if (spin := self.plan.states.get(f"{anchor.name}.{SPIN}")) is not None:
                yield from self._spinning(anchor, axle, spin.place)
            else:
                yield from force_parts(anchor, self.scale, length, axle)

    def _spinning(self, tyre: Anchor, axle: Array, place: int) -> Look:
        """Yield a wheel whose spin is a state, at a place in v, in a frame of its own."""
        number = self._add(spun(tyre.name, tyre.bodies[0], tyre.points[0], axle, place))
        centred = tyre._replace(points=(ORIGIN, ORIGIN), bodies=(number, number))
        yield from _tyre(centred._replace(description="tyre"), axle)

    def _roads(self, roads: Sequence[Road]) -> Iterator[Part]:
        """Yield the slabs, those that move in frames of their own."""
        number = count(1)
        for part, bump in roads:
            moved = self._add(lifted(f"road {next(number)}", bump)) if bump else part.body
            yield part._replace(body=moved)

    def _add(self, frame: MovingFrame) -> int:
        """The number of a frame behind those of the bodies."""
        self.moving.append(frame)
        return len(self.plan.bodies) + len(self.moving)

    def _axle(self, tyre: Anchor) -> Array:
        """The axis of a wheel in axes of its body: the given one, that of a hinge near it, or across the way ahead."""
        body, place = tyre.bodies[0], tyre.points[0]
        if tyre.kind in ROLLING:
            return self.model.bodies[body - 1].pose().local_vector(np.asarray(tyre.part.axis, dtype=float))
        for joint in self.joints:
            for side, number in enumerate(joint.bodies):
                near = np.linalg.norm(joint.points[side] - place) < self.unit
                if number == body and near and joint.kind == "revolute":
                    return joint.axes[side][:, 2]
        return np.asarray(body_frame(self.plan.q, body)[1].T @ upright(self.up)[:, 1])

    def _tyres(self) -> list[Anchor]:
        return [anchor for anchor in self.forces if anchor.kind in TYRES]

    def _displacements(self) -> Iterator[tuple[str, tuple[float, float]]]:
        for anchor in self.joints:
            if anchor.kind in RAILS:
                displacements = [self._displacement(anchor, q) for q in self.positions]
                yield anchor.name, (min(displacements), max(displacements))

    def _displacement(self, anchor: Anchor, q: Array) -> float:
        i, j = self._places(anchor, q)
        return float((j - i) @ body_frame(q, anchor.bodies[0])[1] @ anchor.axes[0][:, 2])

    def _distance(self, anchor: Anchor) -> float:
        i, j = self._places(anchor, self.positions[0])
        return float(np.linalg.norm(j - i))

    def _places(self, anchor: Anchor, q: Array) -> tuple[Array, Array]:
        i, j = (place_of(q, body, point) for body, point in zip(anchor.bodies, anchor.points, strict=True))
        return i, j

    def _extent(self) -> tuple[float, float]:
        """Size of the drawing in its first position, and the lowest height in all of them."""
        places = [self._all_places(q) for q in self.positions]
        first = places[0]
        size = float(np.linalg.norm(first.max(axis=0) - first.min(axis=0)))
        low = float(min((points @ self.up).min() for points in places))
        return (size if size > SMALLEST_LENGTH else _lonely(self.masses)), low

    def _all_places(self, q: Array) -> Array:
        points = [place_of(q, n, center) for n, (_, _, center) in self.masses.items()]
        for anchor in (*self.joints, *self.forces):
            points += self._places(anchor, q)
            if anchor.kind in TYRES:
                points.append(points[-1] - float(anchor.part.radius) * self.up)
        return np.array(points)

    def _unit(self) -> float:
        extents = [
            max(_apart([*points_of(n, self.joints), self.masses[n][2]]), default=0.0) for n in self.masses
        ]
        known = [extent for extent in extents if extent > SMALLEST_LENGTH]
        typical = float(np.median(known)) if known else self.size
        return float(np.clip(LOOK.rod * typical, LOOK.thinnest * self.size, LOOK.thickest * self.size))


def _apart(points: Sequence[Array]) -> list[float]:
    return [float(np.linalg.norm(a - b)) for a, b in combinations(points, 2)]


def _lonely(masses: dict[int, tuple[float, Array, Array]]) -> float:
    """The size of a drawing of bodies in one place: of what has their inertia."""
    sizes = [4 * float(np.sqrt(np.trace(inertia) / mass)) for mass, inertia, _ in masses.values()]
    return max([*sizes, SMALLEST_LENGTH])


def _long(anchor: Anchor, length: float) -> Anchor:
    """The anchor of a link that was given without a length, with its length in the first position."""
    if getattr(anchor.part, "length", 0.0) is not None:
        return anchor
    return anchor._replace(part=replace(anchor.part, length=length))


def _color(number: int) -> str:
    return PALETTE[(number - 1) % len(PALETTE)]


def force_parts(anchor: Anchor, scale: DrawingScale, length: float, axle: Array) -> Look:
    """Yield what a force looks like.

    ``length`` is the distance of its points [m], ``axle`` the axis of a wheel in axes of its body.
    """
    known = anchor._replace(description=DESCRIPTIONS.get(anchor.kind, anchor.description))
    if anchor.kind in TYRES:
        yield from _tyre(known, axle)
    elif anchor.kind in _LOOKS:
        yield from _LOOKS[anchor.kind](known, scale, length)


def _acts(value: Any) -> bool:
    return not (isinstance(value, (int, float)) and value == 0)


def _spring(anchor: Anchor, scale: DrawingScale, length: float) -> Look:
    damped = _acts(anchor.part.c)
    radius = min(1.5 * scale.unit, 0.16 * length)
    if 0 in anchor.bodies:
        yield mount(anchor, scale)
    if _acts(anchor.part.k) or not damped:
        yield anchor.spanned("force", length, coil(length, radius, 0.16 * radius), SPRING)
    if damped:
        yield from _dashpot(anchor, length, 0.5 * radius)


def _dashpot(anchor: Anchor, length: float, radius: float) -> Look:
    cylinder = joined([disc(0.35 * radius, 0.0, 0.1 * length), disc(radius, 0.1 * length, 0.55 * length)])
    piston = rod(0.35 * length * Z, length * Z, 0.35 * radius)
    yield anchor.spanned("force", length, cylinder, DAMPER, "start")
    yield anchor.spanned("force", length, piston, DARK, "end")


def _torsion(anchor: Anchor, scale: DrawingScale, length: float) -> Look:
    yield anchor.held("force", 1, spiral(0.8 * scale.unit, 2.6 * scale.unit, 0.2 * scale.unit), SPRING)


def _bushing(anchor: Anchor, scale: DrawingScale, length: float) -> Look:
    yield anchor.held("force", 1, ring(1.4 * scale.unit, 0.7 * scale.unit), RUBBER, 0.85)


def _sphere(anchor: Anchor, scale: DrawingScale, length: float) -> Look:
    yield anchor.held("force", 0, ball(float(anchor.part.radius) or 0.6 * scale.unit), RUBBER, 0.8)


def _limit(anchor: Anchor, scale: DrawingScale, length: float) -> Look:
    yield anchor.spanned("force", length, rod(0 * Z, length * Z, 0.15 * scale.unit), DAMPER)


def _beam(anchor: Anchor, scale: DrawingScale, length: float) -> Look:
    """A straight rod with the area of the section, at least as thick as can be seen."""
    radius = max(0.15 * scale.unit, float(anchor.part.section_area() / pi) ** 0.5)
    yield anchor.spanned("force", length, rod(0 * Z, length * Z, radius), STEEL)


def _push(anchor: Anchor, scale: DrawingScale, length: float) -> Look:
    yield anchor.held("force", 0, ball(0.5 * scale.unit), SPRING)


def _tyre(anchor: Anchor, axle: Array) -> Look:
    radius, turned = float(anchor.part.radius), anchor._replace(axes=(along(axle), anchor.axes[1]))
    yield turned.held("force", 0, wheel(radius, 0.55 * radius), RUBBER)
    yield turned.held("force", 0, rim(radius, 0.55 * radius), STEEL)


_LOOKS: dict[str, Callable[[Anchor, DrawingScale, float], Look]] = {
    "tsda": _spring,
    "rsda": _torsion,
    "bushing": _bushing,
    "sphere_contact": _sphere,
    "length_stop": _limit,
    "beam": _beam,
    "point_force": _push,
}
