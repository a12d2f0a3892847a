"""``load_sdf``: from an SDF file to a model."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...model.checks.arguments import checked
from ...model.geometry.motion import Free, Turn
from ...model.geometry.pose import GROUND_POSE
from ...model.quantity import Array, Vec3, Vector, vector
from ...model.show import counted, quote
from ..by_ending import importer
from ..loops import close
from ..robot import Description, Edge, ImportOptions, Link, Mimic, Robot, build
from ..robot.description import WORLD
from ..robot.options import Base, InertiaOption, MeshOption, MimicOption, check_floating
from ..robot.tree.coordinates import spanned
from ..xml.element import Element, left_out, read_xml
from ..xml.reader import Reader
from . import frames
from .frames import SEPARATOR, Name, flag, number
from .includes import Includes
from .joint import AXES, Joint, axis_of, link_of, read_joint, resolved
from .link import read_link, read_visuals
from .models import Models, Part
from .specification import NOTED, REFUSED, USED

GRAVITY = (0.0, 0.0, -9.8)  # [m/s²] of a world that gives none
GEARBOX = "gearbox"
WITHOUT_AXIS = ("ball", "fixed")
WITHOUT = "axes of {n} ball or fixed joint[s] are left out, with their dynamics and limits"


def describe(
    path: Path, *, gravity: Vec3 | None, fixed: bool, ignore: Sequence[str], search: Sequence[Any]
) -> Description:
    """Return the description that an SDF file gives.

    Parameters
    ----------
    gravity : in place of that of the file
    fixed : links that are not connected with the world are fixed to it
    ignore, search : see `load_sdf`

    Raises
    ------
    ModelError
        For anything that is wrong with it, in one message with file, line, part and remedy.
    """
    root = read_xml(path)
    includes = Includes(search, "includes" in ignore)
    world = includes.expanded(_world(root))
    models = Models(world)
    _refuse(models, ignore)
    short = _shortening(world)
    joints = _joints(models, _version(root))
    edges = [_renamed(joint.edge, short) for joint in joints if not _is_static(joint.edge, models)]
    edges += [_static(name, models, short) for name, part in models.links.items() if part.static]
    starts = {short(name): models.frames.pose(name) for name in models.links}

    def root_edge(name: str, link: str) -> Edge:
        return (
            Edge(name, WORLD, link, starts[link])
            if fixed
            else Edge(name, WORLD, link, GROUND_POSE, (Free(name),))
        )

    tree, loops = spanned(starts, edges, root_edge)
    wrong: list[str] = []
    visuals = [one for name, part in models.links.items() for one in read_visuals(part, short(name), wrong)]
    mimics = {name: mimic for joint in joints for name, mimic in joint.mimics.items()}
    mimics = resolved(mimics, models.joints) | _gearboxes(
        models, _version(root), [joint.edge for joint in joints]
    )
    return Description(
        name=_name(world, path),
        file=str(path),
        links={WORLD: Link(WORLD, None)}
        | {short(n): read_link(p, short(n)) for n, p in models.links.items()},
        edges=tree,
        loops=loops,
        root=WORLD,
        gravity=gravity or _gravity(world),
        limits={short(n): limit for joint in joints for n, limit in joint.limits.items()},
        mimics={short(name): mimic._replace(joint=short(mimic.joint)) for name, mimic in mimics.items()},
        dynamics={short(n): values for joint in joints for n, values in joint.dynamics.items()},
        lifted={
            short(n): 1.0 for n, p in models.links.items() if not flag(p.element, "gravity", p.reader, True)
        },
        visuals=visuals,
        notes=[*_notes(root, world, models), *includes.notes, *wrong],
        zero={
            edge.name: [*map(float, starts[edge.child].r), *map(float, starts[edge.child].p)]
            for edge in tree
            if edge.motions and isinstance(edge.motions[0], Free)
        },
    )


def _world(root: Element) -> Element:
    """Return the world of a file, or its models as those of a world without a name."""
    reader = Reader(root.file, "file")
    if root.tag not in ("sdf", "gazebo"):
        raise reader.refusal(
            f"the file is a <{root.tag}>, not an <sdf>. Give an SDF file, or use sarrus.load.", root.line
        )
    worlds, models = list(root.all("world")), [*root.all("model"), *root.all("include")]
    if len(worlds) + len(models) != 1:
        there = counted("{n} world[s]", len(worlds)), counted("{n} model[s]", len(models))
        message = f"has {' and '.join(there)}. Give one world, or one model."
        raise reader.refusal(message, root.line)
    return worlds[0] if worlds else replace(root, tag="world", attributes={}, children=models)


def _version(root: Element) -> int:
    """Return the second number of a version, 12 of 1.12."""
    minor = root.attributes.get("version", "1.12").partition(".")[2]
    return int(minor) if minor.isdecimal() else 12


def _name(world: Element, path: Path) -> str:
    models = [model for model in world.all("model") if len([*world.all("model")]) == 1]
    return models[0].attributes["name"] if models else world.attributes.get("name", path.stem)


def _shortening(world: Element) -> Callable[[str], str]:
    """Return the function that takes the name of the model from names, where there is only one."""
    models = [model.attributes.get("name", "") for model in world.all("model")]
    prefix = f"{models[0]}{SEPARATOR}" if len(models) == 1 else ""
    return lambda name: name.removeprefix(prefix)


def _gravity(world: Element) -> Vec3:
    places = [world, *world.all("physics")]  # in the physics before version 1.5
    for element in (one for place in places for one in place.all("gravity")):
        x, y, z = Reader(world.file, "world").content(element, 3)
        return x, y, z
    return GRAVITY


def _joints(models: Models, version: int) -> list[Joint]:
    parts = models.joints.values()
    return [
        read_joint(part, models, version) for part in parts if part.element.attributes.get("type") != GEARBOX
    ]


def _gearboxes(models: Models, version: int, edges: Sequence[Edge]) -> dict[str, Mimic]:
    boxes = [part for part in models.joints.values() if part.element.attributes.get("type") == GEARBOX]
    return dict(gearbox(part, models, version, edges) for part in boxes)


def _renamed(edge: Edge, short: Callable[[str], str]) -> Edge:
    motions = tuple(replace(motion, name=short(motion.name)) for motion in edge.motions)
    names = {field: short(getattr(edge, field)) for field in ("name", "parent", "child")}
    return replace(edge, motions=motions, **names)  # type: ignore[arg-type]


def _is_static(edge: Edge, models: Models) -> bool:
    return all(link == WORLD or models.links[link].static for link in (edge.parent, edge.child))


def _static(name: str, models: Models, short: Callable[[str], str]) -> Edge:
    return Edge(f"{short(name)}_static", WORLD, short(name), models.frames.pose(name))


def _refuse(models: Models, ignore: Sequence[str]) -> None:
    """Refuse what changes the motion, unless it is ignored."""
    for part in models.links.values():
        for path, (word, what) in REFUSED.items():
            for element in _below(part.element, path.split("/")[2:]):
                if word not in ignore and _is_on(element):
                    message = f"{what}. Remove <{element.tag}>, or import the file with ignore=[{word!r}]."
                    raise part.reader.refusal(message, element.line)


def _below(element: Element, tags: Sequence[str]) -> Iterator[Element]:
    if not tags:
        yield element
    for child in element.all(tags[0]) if tags else ():
        yield from _below(child, tags[1:])


def _is_on(element: Element) -> bool:
    """Return whether an element, or one in it, is true or no zero."""
    if element.children:
        return any(map(_is_on, element.children))
    return bool(element.text.strip("0.")) and element.text.lower() != "false"


def _notes(root: Element, world: Element, models: Models) -> list[str]:
    """Return one message for each kind of thing that is left out."""
    bare = [
        replace(one, children=[c for c in one.children if c.tag not in ("model", "world", "include")])
        for one in (root, world, *(part.element for part in models.models))
    ]
    notes = left_out(bare if world.attributes else [bare[0], *bare[2:]], USED, NOTED)
    kinds = [
        part.element for part in models.joints.values() if part.element.attributes.get("type") in WITHOUT_AXIS
    ]
    n = sum(any(element.all("axis")) for element in kinds)
    return [*notes, *([counted(WITHOUT, n)] if n else [])]


def gearbox(part: Part, models: Models, version: int, edges: Sequence[Edge]) -> tuple[str, Mimic]:
    """Return the hinge that follows, and what it follows: θ_2 = -ratio · θ_1.

    θ_1 is the angle from the reference body to the parent about the first axis, θ_2 that to the child about the second.
    """
    reader = part.reader
    body = reader.needed(
        part.element, "gearbox_reference_body", "<gearbox_reference_body>frame</gearbox_reference_body>"
    )
    name = models.frames.full(Name(body.text, part.scope), reader, body.line)
    reference, ends = models.frames.link(name), [link_of(part, tag, models) for tag in ("parent", "child")]
    there = models.frames.pose(ends[1])
    axes = [there.A @ axis_of(part, tag, models, version, there) for tag in AXES]
    (leader, one), (follower, other) = (
        _hinge(part, reference, end, axis, models, edges) for end, axis in zip(ends, axes, strict=True)
    )
    return follower, Mimic(leader, -number(part.element, "gearbox_ratio", reader, 1.0) * one * other)


def _hinge(
    part: Part, reference: str, end: str, axis: Array, models: Models, edges: Sequence[Edge]
) -> tuple[str, float]:
    """Return the hinge between two links, and the sign of its angle from the first to the second about an axis."""
    for edge in edges:
        ends = [frames.WORLD if link == WORLD else link for link in (edge.parent, edge.child)]
        if {*ends} == {reference, end} and len(edge.motions) == 1 and isinstance(edge.motions[0], Turn):
            along = models.frames.pose(edge.child).A @ edge.motions[0].axis @ axis
            return edge.motions[0].name, float(np.sign(along)) * (1.0 if ends[0] == reference else -1.0)
    message = f"there is no hinge between {quote(reference)} and {quote(end)}. Add a revolute joint there."
    raise part.reader.refusal(message, part.element.line)


@importer(".sdf", ".world", ".xml", roots=("sdf", "gazebo"))
@checked
def load_sdf(
    path: str | os.PathLike[str],
    *,
    base: Base = "file",
    q0: Mapping[str, Any] | None = None,
    loops: str | os.PathLike[str] | None = None,
    lock: Sequence[str] = (),
    mimic: MimicOption = "couple",
    inertia: InertiaOption = "check",
    keep_fixed: bool = False,
    gravity: Vector | None = None,
    ignore: Sequence[str] = (),
    meshes: MeshOption = "draw",
    search: Sequence[str | os.PathLike[str]] = (),
) -> Robot:
    """Read a model from an SDF file: a model, or a world with its models, nested and included ones too.

    Links, joints and frames of nested models are named with the model, ``arm::elbow``; names of a file with one model
    do without it. A link with two parents closes a loop. Joints with two axes have the motions ``JOINT.1`` and
    ``JOINT.2``, a screw ``JOINT`` and ``JOINT.displacement``.

    Parameters
    ----------
    path
        The file. Meshes are read when the model is drawn.
    base
        ``"file"`` and ``"floating"``: links that are not connected with the world move freely; the motion of the
        first is named ``base``. ``"fixed"`` fixes the first link of such a model to the world, in its pose.
    q0
        Initial coordinates of joints by name, relative to the pose of the file: angle [rad], displacement [m]; for a
        ball four Euler parameters; for a free link [r, p], by default as in the file.
    loops, lock, mimic, inertia, keep_fixed
        As in `sarrus.load_urdf`.
    gravity
        In global axes [m/s²]; by default that of the world, or (0, 0, -9.8).
    ignore
        Elements to leave out although they change the motion: "kinematic", "decay" (``velocity_decay``), "fluid" (added
        mass), and "includes" that are not found; "dynamics" leaves out springs, dampers and friction of joints.
    meshes
        ``"ignore"`` leaves out visuals that are meshes.
    search
        Folders in which included models and meshes are searched, besides those near the file and in ``SDF_PATH``,
        ``GZ_SIM_RESOURCE_PATH`` and ``GAZEBO_MODEL_PATH``.

    Returns
    -------
    Robot
        Its ``notes`` list what was left out: contact, sensors, plugins, ...

    Raises
    ------
    ModelError
        For anything that is wrong or not supported, in one message with file, line, part and remedy.
    """
    g = None if gravity is None else vector(gravity, "gravity", "Give three numbers in m/s².")
    description = describe(Path(path), gravity=g, fixed=base == "fixed", ignore=ignore, search=search)
    check_floating(base, description.edges)
    given_base = "file" if base == "floating" else base
    options = ImportOptions(
        given_base, q0 or {}, lock, mimic, inertia, keep_fixed, ignore, {}, meshes, search
    )
    return close(build(description, options), loops)
