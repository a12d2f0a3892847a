"""Notes on what a URDF contains and the model does not."""

from __future__ import annotations

from .element import Element

LEFT_OUT = {
    "transmission": "{n} transmissions are left out",
    "gazebo": "{n} <gazebo> extensions are left out",
}


def notes(root: Element) -> list[str]:
    """Return one message for each kind of thing that is left out."""
    found = [_count(message, sum(1 for _ in root.all(tag))) for tag, message in LEFT_OUT.items()]
    collisions = sum(1 for link in root.all("link") for _ in link.all("collision"))
    found.append(_count("{n} collision shapes are left out: there is no contact", collisions))
    found.append(_count("damping or friction of {n} joints is left out", sum(map(_lossy, root.all("joint")))))
    found.append(
        _count("limits of {n} joints are stored, not enforced", sum(map(_limited, root.all("joint"))))
    )
    return [message for message in found if message]


def _count(message: str, n: int) -> str:
    return message.format(n=n) if n else ""


def _lossy(joint: Element) -> bool:
    given = (d.attributes.get(key, "0") for d in joint.all("dynamics") for key in ("damping", "friction"))
    return any(value.strip().strip("0.") for value in given)


def _limited(joint: Element) -> bool:
    return any(True for _ in joint.all("limit"))
