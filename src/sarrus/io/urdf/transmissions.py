"""Simple transmissions: a motor whose torque, times the reduction, acts on one joint."""

from __future__ import annotations

from collections.abc import Collection

from ..plurals import counted
from ..robot import Actuator
from ..xml.element import Element
from ..xml.reader import Reader

SIMPLE = "SimpleTransmission"


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
    given = [*actuator.all("mechanicalReduction"), *element.all("mechanicalReduction")]
    return reader.content(given[0])[0] if given else 1.0
