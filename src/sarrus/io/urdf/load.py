"""``load_urdf``: from a URDF file to a model."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from ...model.checks.arguments import checked
from ...model.quantity import Vec3, Vector, vector
from ...model.show import counted, quote, suggest
from ..by_ending import importer
from ..loops import close
from ..robot import Actuator, Description, Dynamics, Edge, ImportOptions, Link, Robot, build
from ..robot.options import Base, InertiaOption, MeshOption, MimicOption
from ..xml.element import Element, left_out, read_xml
from ..xml.reader import Part, Reader, named
from .gazebo import read_gazebo, read_loops
from .joint import dynamics_of, read_joint, read_limit, read_mimics
from .link import colors_of, read_link, read_visuals
from .loops import marked_loops, with_frame_pairs, with_open_loops_noted

Given = TypeVar("Given")
IMPLICIT_WORLD = "world"
MOST_LINKS = 10_000
CHILDREN = ("link", "joint", "material", "transmission", "gazebo", "sensor")
USED = {
    "robot": "name version",
    "robot/material": "name",
    "robot/material/color": "rgba",
    "robot/link": "name type",
    "robot/link/inertial": "",
    "robot/link/inertial/origin": "xyz rpy",
    "robot/link/inertial/mass": "value",
    "robot/link/inertial/inertia": "ixx ixy ixz iyy iyz izz",
    "robot/link/visual": "name",
    "robot/link/visual/origin": "xyz rpy",
    "robot/link/visual/geometry": "",
    "robot/link/visual/geometry/box": "size",
    "robot/link/visual/geometry/cylinder": "radius length",
    "robot/link/visual/geometry/capsule": "radius length",
    "robot/link/visual/geometry/sphere": "radius",
    "robot/link/visual/geometry/mesh": "filename scale",
    "robot/link/visual/material": "name",
    "robot/link/visual/material/color": "rgba",
    "robot/joint": "name type",
    "robot/joint/origin": "xyz rpy",
    "robot/joint/parent": "link",
    "robot/joint/child": "link",
    "robot/joint/axis": "xyz",
    "robot/joint/dynamics": "damping friction",
    "robot/joint/mimic": "joint multiplier offset",
    "robot/joint/limit": "lower upper effort velocity",
    "robot/joint/safety_controller": "soft_lower_limit soft_upper_limit k_position k_velocity",
}
NOTED = {
    "robot/material/texture": "{n} texture[s] [is|are] left out: shapes have their colors only",
    "robot/link/visual/material/texture": "{n} texture[s] [is|are] left out: shapes have their colors only",
    "robot/link/collision": "{n} collision shape[s] [is|are] left out: there is no contact",
    "robot/joint/limit": "limits of {n} joint[s] are stored, not enforced: joints move beyond them, without stops",
    "robot/joint/safety_controller": "the soft limits of {n} joint[s] are stored, but do not act",
    "robot/joint/calibration": "calibrations of {n} joint[s] are left out: coordinates count from the zero of the file",
    "robot/sensor": "{n} sensor[s] [is|are] left out: the model has outputs by name",
}
ELSEWHERE = ("transmission", "gazebo")  # elements of a robot with their own notes
SIMPLE = "SimpleTransmission"


def describe(path: Path, gravity: Vec3) -> Description:
    """Return the description that a URDF file gives.

    Raises
    ------
    ModelError
        For anything that is wrong with it, in one message with file, line, part and remedy.
    """
    root, file = read_xml(path), str(path)
    _check_root(root, Reader(file, "robot"))
    link_parts, joint_parts = (named(root, tag, Reader(file, "robot")) for tag in ("link", "joint"))
    links = {name: read_link(part.element, name, part.reader) for name, part in link_parts.items()}
    if IMPLICIT_WORLD in _parents(joint_parts):
        links.setdefault(IMPLICIT_WORLD, Link(IMPLICIT_WORLD, None))  # files name it without declaring it
    edges = {name: _edge(part, name, links) for name, part in joint_parts.items()}
    start = root_of(edges, links, file)
    wrong: list[str] = []
    colors = colors_of(root, Reader(file, "robot"))
    visuals = [
        visual
        for name, part in link_parts.items()
        for visual in read_visuals(part.element, name, part.reader, colors, wrong)
    ]
    single = {name for name, edge in edges.items() if [motion.name for motion in edge.motions] == [name]}
    actuators, without_motor = read_transmissions(root, single, file)
    gazebo, tree = read_gazebo(root, file), in_order(edges, links, start, file)
    closing = read_loops(root, tree, start)
    return Description(
        name=root.attributes.get("name", "").strip() or path.stem,
        file=file,
        links=links,
        edges=tree,
        root=start,
        loops=[*marked_loops(links), *(joint.edge for joint in closing)],
        gravity=gravity,
        limits=_given(joint_parts, read_limit) | _merged(joint.limits for joint in closing),
        mimics=read_mimics(joint_parts, edges) | _merged(joint.mimics for joint in closing),
        dynamics=_dynamics(joint_parts, edges, gazebo.springs) | _merged(joint.dynamics for joint in closing),
        actuators=actuators,
        lifted={name: 1.0 for name in gazebo.weightless if name in links},
        visuals=visuals,
        notes=[*_notes(root), *without_motor, *gazebo.notes, *wrong],
    )


def _check_root(root: Element, reader: Reader) -> None:
    if root.tag != "robot":
        raise reader.refusal(
            f"the file is a <{root.tag}>, not a <robot>. Give a URDF file, or use sarrus.load.", root.line
        )
    reader.check(root, ("name", "version"), CHILDREN)
    links = sum(1 for _ in root.all("link"))
    if links > MOST_LINKS:
        message = f"has {links:,} links, more than {MOST_LINKS:,}. Split it, or build it in Python."
        raise reader.refusal(message, root.line)
    if not links:
        raise reader.refusal("has no links. Give at least one.", root.line)


def _edge(part: Part, name: str, links: Mapping[str, Link]) -> Edge:
    edge = read_joint(part.element, name, part.reader)
    for end in (edge.parent, edge.child):
        if end not in links:
            raise part.reader.refusal(f"there is no link {quote(end)}. {suggest(end, links)}", edge.line)
    return edge


def _parents(parts: Mapping[str, Part]) -> set[str]:
    return {end.attributes.get("link", "") for part in parts.values() for end in part.element.all("parent")}


def _merged(mappings: Iterable[Mapping[str, Given]]) -> dict[str, Given]:
    return {name: value for mapping in mappings for name, value in mapping.items()}


def _given(parts: Mapping[str, Part], read: Callable[[Element, Reader], Given | None]) -> dict[str, Given]:
    """Return what is read of each joint, where it has any."""
    values = {name: read(part.element, part.reader) for name, part in parts.items()}
    return {name: value for name, value in values.items() if value}


def _dynamics(
    parts: Mapping[str, Part], edges: Mapping[str, Edge], springs: Mapping[str, tuple[float, float]]
) -> dict[str, Dynamics]:
    """Return the dynamics of each motion that has any."""
    dynamics: dict[str, Dynamics] = {}
    for name, part in parts.items():
        values = dynamics_of(part.element, part.reader, *springs.get(name, (0.0, 0.0)))
        if values != Dynamics():
            dynamics |= {motion.name: values for motion in edges[name].motions}
    return dynamics


def _notes(root: Element) -> list[str]:
    """Return one message for each kind of thing that is left out."""
    rest = [child for child in root.children if child.tag not in ELSEWHERE]
    return left_out([replace(root, children=rest)], USED, NOTED)


def read_transmissions(
    root: Element, joints: Collection[str], file: str
) -> tuple[dict[str, Actuator], list[str]]:
    """Return the motors by name, and a note on transmissions that are left out.

    Parameters
    ----------
    root : the robot
    joints : names of those with one coordinate
    file : for messages
    """
    motors: dict[str, Actuator] = {}
    left = 0
    for element in root.all("transmission"):
        actuators, driven = list(element.all("actuator")), _driven(element)
        if not _is_simple(element) or len(actuators) != 1 or len(driven) != 1 or driven[0] not in joints:
            left += 1
            continue
        name = actuators[0].attributes.get("name") or element.attributes.get("name", driven[0])
        if name in motors:
            name = f"{name}_{driven[0]}"
        motors[name] = Actuator(driven[0], gain=_reduction(element, actuators[0], Reader(file, "robot")))
    if not left:
        return motors, []
    text = (
        "{n} transmission[s] [is|are] left out: only simple ones, to joints with one coordinate, have motors"
    )
    return motors, [counted(text, left)]


def _is_simple(element: Element) -> bool:
    kinds = [element.attributes.get("type", ""), *(child.text for child in element.all("type"))]
    return all(not kind or kind.endswith(SIMPLE) for kind in kinds)


def _driven(element: Element) -> list[str]:
    return [joint.attributes.get("name", "") for joint in element.all("joint")]


def _reduction(element: Element, actuator: Element, reader: Reader) -> float:
    reductions = [*actuator.all("mechanicalReduction"), *element.all("mechanicalReduction")]
    return reader.content(reductions[0])[0] if reductions else 1.0


def root_of(edges: Mapping[str, Edge], links: Mapping[str, Link], file: str) -> str:
    """Return the only link that is no child, or raise a ModelError."""
    above: dict[str, Edge] = {}
    for edge in edges.values():
        if edge.child in above:
            other = above[edge.child]
            message = f"link {quote(edge.child)} is already the child of joint {quote(other.name)}"
            remedy = "Close the loop with a joint in a loops file: a URDF is a tree."
            raise Reader(file, f"joint {quote(edge.name)}").refusal(f"{message}. {remedy}", edge.line)
        above[edge.child] = edge
    roots = [link for link in links.values() if link.name not in above]
    if not roots:
        message = "every link is the child of a joint, so none is the root. Let one link be no child."
        raise Reader(file, "robot").refusal(message, 1)
    if len(roots) > 1:
        names = " and ".join(quote(link.name) for link in roots[:2])
        message = f"{names} both are no child of a joint. Connect all links into one tree."
        raise Reader(file, "robot").refusal(message, roots[1].line)
    return roots[0].name


def in_order(edges: Mapping[str, Edge], links: Mapping[str, Link], root: str, file: str) -> list[Edge]:
    """Return the edges from the root outward, or raise a ModelError if some hang together in a circle."""
    below: dict[str, list[Edge]] = {}
    for edge in edges.values():
        below.setdefault(edge.parent, []).append(edge)
    order: list[Edge] = []
    waiting = list(reversed(below.get(root, [])))
    while waiting:
        order.append(waiting.pop())
        waiting += reversed(below.get(order[-1].child, []))
    _refuse_circle(edges, order, root, file)
    return order


def _refuse_circle(edges: Mapping[str, Edge], order: list[Edge], root: str, file: str) -> None:
    reached = {edge.name for edge in order}
    for edge in edges.values():
        if edge.name not in reached:
            message = f"hangs in a circle of joints that does not reach the root {quote(root)}"
            remedy = "Let one of them have its parent in the tree."
            raise Reader(file, f"joint {quote(edge.name)}").refusal(f"{message}. {remedy}", edge.line)


GRAVITY = (0.0, 0.0, -9.81)  # [m/s²] as every simulator of URDF assumes


@importer(".urdf", ".xml", roots=("robot",))
@checked
def load_urdf(
    path: str | os.PathLike[str],
    *,
    base: Base = "fixed",
    q0: Mapping[str, Any] | None = None,
    loops: str | os.PathLike[str] | None = None,
    lock: Sequence[str] = (),
    mimic: MimicOption = "couple",
    inertia: InertiaOption = "check",
    keep_fixed: bool = False,
    gravity: Vector = GRAVITY,
    ignore: Sequence[str] = (),
    controls: Mapping[str, Any] | None = None,
    meshes: MeshOption = "draw",
    search: Sequence[str | os.PathLike[str]] = (),
) -> Robot:
    """Read a robot from a URDF file.

    Each moving link becomes a body with the frame of the link. Links that are fixed to it are merged into it; their
    points and frames are available by ``robot.link(name)``. Visuals and limits are stored; limits are used only for the
    choice of a position with closed loops.

    Parameters
    ----------
    path
        The file. Meshes are read when the model is drawn.
    base
        ``"fixed"``: the root link is the ground. ``"floating"``: it is a body that moves freely; its motion is named
        ``base``.
    q0
        Initial coordinates of joints by name: angle [rad], displacement [m]; for a floating joint [r, p], seven
        numbers. The others start at zero. A planar joint ``j`` has the three motions ``j.x``, ``j.y`` and ``j.angle``.
    loops
        A YAML or JSON file with further ``joints`` and ``forces`` between links, in the form of a model file; or with
        pairs of frames that coincide (``closed_loop``), in the form of ``example-parallel-robots``.
    lock
        Joints that are locked in their initial position.
    mimic
        Joints that follow another: ``"couple"`` them, take them as ``"free"``, or ``"lock"`` them as well.
    inertia
        ``"check"`` refuses tensors that no distribution of mass has; ``"given"`` accepts them unchanged.
    keep_fixed
        Import fixed links with mass as separate bodies with a fixed joint.
    gravity
        In global axes [m/s²].
    ignore
        ``["dynamics"]`` leaves out damping and dry friction of joints, ``["actuators"]`` the motors of transmissions.
    controls
        Torques of the motors of simple transmissions by name: a number, or a formula of the time, ``"0.3*sin(2*t)"``.
        The joint has this torque times the reduction. The others are zero.
    meshes
        ``"ignore"`` leaves out visuals that are meshes.
    search
        Folders in which ``package://`` names and meshes are searched, besides those near the file and in
        ``ROS_PACKAGE_PATH`` and ``AMENT_PREFIX_PATH``.

    Returns
    -------
    Robot
        A `Model` that also knows its links, limits and joint space.

    Raises
    ------
    ModelError
        For anything that is wrong, in one message with file, line, part and remedy.
    """
    description = describe(Path(path), vector(gravity, "gravity", "Give three numbers in m/s²."))
    options = ImportOptions(
        base, q0 or {}, lock, mimic, inertia, keep_fixed, ignore, controls or {}, meshes, search
    )
    description, side_file = with_frame_pairs(description, loops)
    return with_open_loops_noted(close(build(description, options), side_file), description.links)
