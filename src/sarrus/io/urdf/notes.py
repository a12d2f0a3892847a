"""What a URDF says and the model does not, in sentences."""

from __future__ import annotations

from .element import Element

SAID = {
    "transmission": "{n} transmissions are left out",
    "gazebo": "{n} <gazebo> extensions are left out",
}


def notes(root: Element) -> list[str]:
    """Return one sentence for each kind of thing that is left out."""
    found = [_count(told, sum(1 for _ in root.all(tag))) for tag, told in SAID.items()]
    collisions = sum(1 for link in root.all("link") for _ in link.all("collision"))
    found.append(_count("{n} collision shapes are left out: there is no contact", collisions))
    found.append(_count("damping or friction of {n} joints is left out", sum(map(_lossy, root.all("joint")))))
    found.append(_count("limits of {n} joints are kept, not enforced", sum(map(_limited, root.all("joint")))))
    return [told for told in found if told]


def _count(told: str, n: int) -> str:
    return told.format(n=n) if n else ""


def _lossy(joint: Element) -> bool:
    given = (d.attributes.get(key, "0") for d in joint.all("dynamics") for key in ("damping", "friction"))
    return any(value.strip().strip("0.") for value in given)


def _limited(joint: Element) -> bool:
    return any(True for _ in joint.all("limit"))
