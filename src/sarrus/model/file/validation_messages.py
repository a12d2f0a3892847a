"""Messages for pydantic's findings, each about one part of the model."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pydantic import ValidationError

from ..checks.findings import KINDS, Path, part_name, path_text
from ..errors import ModelError
from ..show import quote, show, suggest
from .numbers import FORMS
from .text.document import Document


def first_error(error: ValidationError, document: Document) -> ModelError:
    """Return the ModelError for the first finding, with the number of the others."""
    errors = error.errors(include_url=False)
    # An echo repeats an error that is reported at its own place; it counts only if nothing else is wrong.
    findings = [one for one in errors if one["type"] != "echo"] or errors[:1]
    finding: dict[str, Any] = dict(findings[0])
    path = _path(finding, document.data)
    subject = path_text(path[2:] if path and path[0] in KINDS and len(path) > 1 else path)
    message = _message(finding, str(path[-1]) if path else "")
    return ModelError(
        f"{subject} {message}" if subject else message,
        part=part_name(path),
        where=document.origin.where((*path, _key(finding))),
        more=len(findings) - 1,
    )


def _path(finding: dict[str, Any], data: Any) -> Path:
    """Return the place in the file, without the tags that pydantic adds for unions."""
    steps = list(finding["loc"])
    if len(steps) > 2 and steps[0] in ("joints", "drivers", "forces"):
        del steps[2]
    return tuple(step for step in steps if not (isinstance(step, str) and step.startswith("(")))


def _key(finding: dict[str, Any]) -> str:
    """Return the key of the place that a finding is about, if it is one."""
    return "type" if finding["type"] == "union_tag_invalid" else str(finding.get("ctx", {}).get("key", ""))


def _message(finding: dict[str, Any], field: str) -> str:
    kind, ctx, value = finding["type"], finding.get("ctx", {}), finding["input"]
    if kind == "list_type":
        return _wrong("a list", LISTS.get(field, "Write it in brackets, as in [0, 0, 1]."))(ctx, value)
    text_of = MESSAGES.get(kind)
    return text_of(ctx, value) if text_of else f"{finding['msg'].lower()}, but is {show(value)}. Correct it."


def _wrong(expected: str, remedy: str) -> Callable[[dict[str, Any], Any], str]:
    return lambda ctx, value: f"must be {expected}, but is {show(value)}. {remedy}"


def _length(ctx: dict[str, Any], value: Any) -> str:
    wanted = ctx.get("min_length", ctx.get("max_length"))
    nested = any(isinstance(entry, list) for entry in value)
    least = "at least " if "min_length" in ctx and wanted == 2 and nested else ""
    return f"must have {least}{wanted} entries, but has {len(value)}. Give {least}{wanted}."


def _literal(ctx: dict[str, Any], value: Any) -> str:
    right = [word.strip(" '") for word in str(ctx["expected"]).replace(" or ", ", ").split(",")]
    return f"must be one of {', '.join(right)}, but is {show(value)}. {suggest(str(value), right)}"


def _tag(ctx: dict[str, Any], value: Any) -> str:
    right = [word.strip(" '") for word in str(ctx["expected_tags"]).split(",")]
    given = str(ctx["tag"])
    meant = [kind for kind in MEANT.get(given.lower().replace(" ", "_"), ()) if kind in right]
    hint = f"Did you mean {' or '.join(map(quote, meant))}?" if meant else suggest(given, right)
    return f"has the unknown type {quote(given)}. {hint}"


MEANT = {  # the types of joints, drivers and forces by other names that they have
    **dict.fromkeys(("spring", "damper", "spring_damper", "shock", "strut", "actuator"), ("tsda", "rsda")),
    **dict.fromkeys(("torsion_spring", "rotational_spring", "torsional_spring"), ("rsda",)),
    **dict.fromkeys(("hinge", "pin", "rotational", "rotary", "pivot"), ("revolute",)),
    **dict.fromkeys(("slider", "slide", "prismatic", "linear"), ("translational",)),
    **dict.fromkeys(("ball", "ball_joint", "ball_and_socket", "socket"), ("spherical",)),
    **dict.fromkeys(("weld", "rigid", "lock", "bolted"), ("fixed",)),
    **dict.fromkeys(("cardan", "hooke", "u_joint", "cross"), ("universal",)),
    **dict.fromkeys(
        ("link", "rod", "massless_link"), ("distance", "revolute_revolute", "revolute_spherical")
    ),
    **dict.fromkeys(("helical",), ("screw",)),
    **dict.fromkeys(("gears", "gear_pair"), ("gear",)),
    **dict.fromkeys(("rack", "pinion"), ("rack_and_pinion",)),
    **dict.fromkeys(("motor", "rotation", "angle_driver"), ("angle",)),
    **dict.fromkeys(("translation", "cylinder"), ("displacement", "tsda")),
    "load": ("point_force", "force"),
    **dict.fromkeys(("moment",), ("torque",)),
    **dict.fromkeys(("mount", "rubber"), ("bushing",)),
    **dict.fromkeys(("contact", "ball_contact"), ("sphere_contact",)),
    **dict.fromkeys(("wheel", "tire"), ("tyre", "road_tyre")),
    **dict.fromkeys(("friction",), ("angle_friction", "displacement_friction")),
    **dict.fromkeys(
        ("stop", "limit", "bumper", "end_stop"), ("length_stop", "displacement_stop", "angle_stop")
    ),
}
LISTS = {  # how a list is written, where three numbers are not the only form
    "inertia": "Write it in brackets, as in [1, 1, 1] for the principal moments, or {xx: 1, yy: 1, zz: 1}.",
    "orientation": "Write Euler parameters as [1, 0, 0, 0], a rotation as {axis: [0, 0, 1], angle: 1.57} or "
    "{angles: [0, 0, 1.57], sequence: xyz}, or three rows of a matrix.",
    "bodies": "Write two names in brackets, as in [ground, rod].",
    "points": "Write two points in brackets, as in [{body: ground, at: [0, 0, 0]}, {body: rod, at: [1, 0, 0]}].",
}
_mapping = _wrong("a mapping", "Give keys and values, as in key: value.")

MESSAGES: dict[str, Callable[[dict[str, Any], Any], str]] = {
    "invalid": lambda ctx, value: str(ctx["message"]),
    "echo": lambda ctx, value: str(ctx["message"]),
    "missing": lambda ctx, value: "is missing. Add it.",
    "float_type": _wrong("a number", FORMS),
    "finite_number": _wrong("a finite number", "Check its size and unit."),
    "string_type": _wrong("a text", "Put it in quotes if it looks like a number."),
    "mapping_type": _mapping,
    "dict_type": _mapping,
    "model_type": _mapping,
    "model_attributes_type": _mapping,
    "too_short": _length,
    "too_long": _length,
    "literal_error": _literal,
    "union_tag_invalid": _tag,
    "union_tag_not_found": lambda ctx, value: "type is missing. Add it, as in type: revolute.",
}
