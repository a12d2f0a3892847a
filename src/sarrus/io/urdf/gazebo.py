"""Extensions for the simulator Gazebo: joints that close loops, springs, links without weight; notes on the others."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from ...model.geometry.motion import compose
from ...model.geometry.pose import GROUND_POSE, Pose
from ...model.show import counted
from ..robot import Edge
from ..sdf.frames import QUATERNION, WORLD
from ..sdf.joint import IN_JOINT_AXES, Joint, read_joint
from ..sdf.models import Models
from ..xml.element import Element
from ..xml.reader import Reader

SPRING = ("springStiffness", "springReference")
WEIGHT = ("turnGravityOff", "gravity")
LUMPING = (
    "preserveFixedJoint",
    "disableFixedJointLumping",
    "disableJointLumping",
)  # does not change a motion
SILENT = (*LUMPING, "material", "implicitSpringDamper")
UNKNOWN = "what [it does|they do] to the motion is not known"
CONSEQUENCES = {
    **dict.fromkeys(("plugin", "joint", "link", "model", "frame"), UNKNOWN),
    "sensor": "the model has outputs by name",
    "dampingFactor": "the velocities of links do not decay",
    "kinematic": "the links move by forces",
    "static": "links move as their joints allow",
    "provideFeedback": "all reactions are outputs",
}
CONTACT = "there is no contact, and joint limits do not act"


class Extensions(NamedTuple):
    """Spring stiffness and free value by joint, links without weight, and notes."""

    springs: dict[str, tuple[float, float]]
    weightless: list[str]
    notes: list[str]


def read_gazebo(root: Element, file: str) -> Extensions:
    """Return the content of the <gazebo> elements of a robot."""
    reader, springs, weightless = Reader(file, "robot"), dict[str, tuple[float, float]](), list[str]()
    for element in root.all("gazebo"):
        name = element.attributes.get("reference", "")
        stiffness, free = (_number(element, tag, reader) for tag in SPRING)
        if stiffness:
            springs[name] = stiffness, free
        if any(
            reader.flag(child) == (child.tag == WEIGHT[0]) for tag in WEIGHT for child in element.all(tag)
        ):
            weightless.append(name)
    counts = Counter(_left_out(root))
    notes = [
        counted(f"{{n}} <{tag}> of <gazebo> [is|are] left out: {CONSEQUENCES.get(tag, CONTACT)}", n)
        for tag, n in counts.items()
    ]
    return Extensions(springs, weightless, notes)


def _number(element: Element, tag: str, reader: Reader) -> float:
    return next((reader.content(child)[0] for child in element.all(tag)), 0.0)


def _left_out(root: Element) -> Iterator[str]:
    for element in root.all("gazebo"):
        used = (*SPRING, *WEIGHT, *SILENT, *(() if element.attributes else ("joint",)))
        yield from (child.tag for child in element.children if child.tag not in used)


def read_loops(root: Element, edges: Sequence[Edge], start: str) -> list[Joint]:
    """Return the joints of <gazebo>, which are those of an SDF file: frames at links, where all coordinates are zero.

    Parameters
    ----------
    edges : the tree from the root outward
    start : the root
    """
    poses = {start: GROUND_POSE}
    for edge in edges:
        poses[edge.child] = compose(poses[edge.parent], edge.pose)
    links = [_placed(name, pose, root) for name, pose in poses.items()]
    joints = [joint for one in root.all("gazebo") if not one.attributes for joint in one.all("joint")]
    models = Models(replace(root, tag="world", children=[*links, *joints]))
    taken = {edge.name for edge in edges}
    for part in models.joints.values():
        if part.name in taken:
            raise part.reader.refusal("has the name of another joint. Rename it.", part.element.line)
    found = [read_joint(part, models, IN_JOINT_AXES) for part in models.joints.values()]
    plain = (
        {n: one._replace(joint=one.joint.partition("@")[0]) for n, one in j.mimics.items()} for j in found
    )
    return [joint._replace(mimics=mimics) for joint, mimics in zip(found, plain, strict=True)]


def _placed(name: str, pose: Pose, root: Element) -> Element:
    """Return a link of an SDF file."""
    numbers = " ".join(map(repr, map(float, (*pose.r, *pose.p[1:], pose.p[0]))))
    attributes = {"relative_to": WORLD, "rotation_format": QUATERNION}
    place = Element("pose", attributes, root.line, pieces=[numbers], file=root.file)
    return Element("link", {"name": name}, root.line, [place], file=root.file)
