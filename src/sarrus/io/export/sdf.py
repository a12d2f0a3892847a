"""Models as SDF: links with poses, joints between them, loops by links with two parents."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element

import numpy as np

from ...model import Fixed, Revolute, Spherical, Translational, Universal
from ...model.bodies.shape import Look
from ...model.geometry.motion import Ball, Motion, Slide, Turn
from ...model.geometry.points import GROUND
from ...model.quantity import Array
from ..robot import Dynamics, Edge
from ..robot.description import legal
from ..robot.joints import LETTERS
from .contents import Contents, missing_loads, warn_of_rates
from .looks import looks_by_body, rgba, sizes
from .missing import Gap
from .xml import child, numbers, text_of

CUT = (Fixed, Revolute, Spherical, Translational, Universal)
DYNAMICS = ("stiffness", "free", "damping", "friction")
KINDS = {"": "fixed", "T": "revolute", "S": "prismatic", "B": "ball", "TT": "universal", "F": ""}
NO_JOINT = "no joint with these motions, nor massless links for several joints in series"


def missing(contents: Contents) -> list[Gap]:
    """Return what the format does not have."""
    edges = (*contents.edges, *contents.loops)
    wrong = [Gap(NO_JOINT, (edge.name,)) for edge in edges if not _is_joint(edge)]
    return [*wrong, *missing_loads(contents, DYNAMICS)]


def sdf(contents: Contents) -> str:
    """Return the text of an SDF file."""
    warn_of_rates(contents)
    root = Element("sdf", version="1.11")
    world = child(root, "world", name="world")
    child(world, "gravity", numbers(contents.gravity))
    model = child(world, "model", name=contents.name)
    looks = looks_by_body(contents)
    for edge in contents.edges:
        _link(model, contents, edge.child, looks.get(edge.child, ()))
    for edge in (*contents.edges, *contents.loops):
        _joint(model, contents, edge)
    if GROUND in looks:
        _ground(model, contents, looks[GROUND])
    return text_of(root)


def _ground(model: Element, contents: Contents, looks: Sequence[Look]) -> None:
    """Write the shapes of the ground as those of a link that is fixed to the world."""
    taken = {motion.name for edge in contents.edges for motion in edge.motions}
    taken |= {name for edge in (*contents.edges, *contents.loops) for name in (edge.name, edge.child)}
    names = legal(["shapes", "shapes_fixed"], taken, "_of_ground")
    _shapes(child(model, "link", name=names["shapes"]), looks)
    joint = child(model, "joint", name=names["shapes_fixed"], type="fixed")
    child(joint, "parent", "world")
    child(joint, "child", names["shapes"])


def _shapes(link: Element, looks: Sequence[Look]) -> None:
    for n, look in enumerate(looks, 1):
        _visual(child(link, "visual", name=f"shape{n}"), look)


def _link(model: Element, contents: Contents, name: str, looks: Sequence[Look]) -> None:
    link = child(model, "link", name=name)
    r, p, _ = contents.poses[name]
    w, x, y, z = p
    child(link, "pose", numbers([*r, x, y, z, w]), rotation_format="quat_xyzw")
    _shapes(link, looks)
    mass, center, J = contents.inertials[name]
    inertial = child(link, "inertial")
    child(inertial, "pose", numbers([*center, 0, 0, 0]))
    child(inertial, "mass", numbers([mass]))
    tensor = child(inertial, "inertia")
    for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
        child(tensor, f"i{'xyz'[i]}{'xyz'[j]}", numbers([J[i, j]]))


def _visual(visual: Element, look: Look) -> None:
    r, p, _ = look.pose
    child(visual, "pose", numbers([*r, *p[1:], p[0]]), rotation_format="quat_xyzw")
    shape = child(child(visual, "geometry"), look.shape)
    if look.file is not None:
        child(shape, "uri", look.file.as_posix())
    for tag, values in sizes(look):
        child(shape, tag, numbers(values))
    color = rgba(look)
    if color is not None:
        child(child(visual, "material"), "diffuse", numbers(color))


def _pattern(edge: Edge) -> str:
    return "".join(LETTERS[type(motion)] for motion in edge.motions)


def _points(edge: Edge) -> list[Array]:
    return [motion.point for motion in edge.motions if isinstance(motion, Turn | Ball)]


def _is_joint(edge: Edge) -> bool:
    """Whether a joint of the format has these motions."""
    points = _points(edge)
    return _pattern(edge) in KINDS and all(np.linalg.norm(point - points[0]) <= 1e-12 for point in points)


def _joint(model: Element, contents: Contents, edge: Edge) -> None:
    pattern, points = _pattern(edge), _points(edge)
    if pattern == "F":
        return
    name = edge.motions[0].name if len(edge.motions) == 1 else edge.name
    joint = child(model, "joint", name=name, type=KINDS[pattern])
    child(joint, "parent", edge.parent or "world")
    child(joint, "child", edge.child)
    child(joint, "pose", numbers([*(points[0] if points else np.zeros(3)), 0, 0, 0]))
    for tag, motion in zip(("axis", "axis2"), edge.motions, strict=False):
        if isinstance(motion, Turn | Slide):
            _axis(child(joint, tag), contents, motion, motion.axis)


def _axis(element: Element, contents: Contents, motion: Motion, axis: Array) -> None:
    child(element, "xyz", numbers(axis))
    given = contents.dynamics.get(motion.name, Dynamics())
    if given != Dynamics():
        dynamics = child(element, "dynamics")
        values = {"damping": given.damping, "friction": given.friction}
        values |= {"spring_stiffness": given.stiffness, "spring_reference": given.free}
        for tag, value in values.items():
            child(dynamics, tag, numbers([value]))
    if motion.name in contents.ranges:
        limit = child(element, "limit")
        for tag, end in zip(("lower", "upper"), contents.ranges[motion.name], strict=True):
            if end is not None:
                child(limit, tag, numbers([end]))
    if motion.name in contents.mimics:
        mimic = child(element, "mimic", joint=contents.mimics[motion.name].joint)
        child(mimic, "multiplier", numbers([contents.mimics[motion.name].multiplier]))
