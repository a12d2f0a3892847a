"""Extensions for the simulator Gazebo: springs of joints and links without weight; notes on the others."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

from ..plurals import counted
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
CONSEQUENCES = {
    "plugin": "what [it does|they do] to the motion is not known",
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
        yield from (child.tag for child in element.children if child.tag not in (*SPRING, *WEIGHT, *SILENT))
