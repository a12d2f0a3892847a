"""Deprecated spellings of public names: accepted for one release, with a DeprecationWarning. All are listed here."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Container
from functools import wraps
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")
C = TypeVar("C", bound=type)

RENAMED = {"keep_steps": "store_steps"}  # old keyword: new keyword, in every function that has the new one
CLASSES = {  # names of `sarrus`
    "Happened": "EventRecord",
    "Turn": "Rotation",
    "TravelDriver": "DisplacementDriver",
    "TravelFriction": "DisplacementFriction",
    "TravelStop": "DisplacementStop",
}
ATTRIBUTES = {  # by class
    "Branch": {"trouble": "failure"},
    "JointMotion": {"travel": "displacement"},
    "Mobility": {"kept": "independent_rows"},
    "StudyTable": {"to_pandas": "to_frame"},
    "System": {"number_names": "parameter_names"},
    "SystemJoint": {"travel": "displacement"},
}
TYPES = {  # of the parts of a model file
    "travel": "displacement",
    "travel_friction": "displacement_friction",
    "travel_stop": "displacement_stop",
}
OTHER_NAMES = {  # of types, which people write
    "spring": "tsda",
    "hinge": "revolute",
    "prismatic": "translational",
    "ball": "spherical",
    "weld": "fixed",
}
OUTPUTS = {  # words in names of outputs
    re.compile(r"(?<![A-Za-z0-9_])travel(?=(_[xy])?(\.|$))"): "displacement",
    re.compile(r"(?<=\.)turn(?=_[xyz](\.|$))"): "rotation",
}


def warn_deprecated(old: str, new: str, depth: int = 2) -> None:
    """Warn who called the function that calls this one, or who is further up by a depth."""
    warnings.warn(f"{old} is deprecated. Use {new}.", DeprecationWarning, stacklevel=depth + 1)


def accepts_deprecated_keywords(function: Callable[P, R]) -> Callable[P, R]:
    """Decorate an analysis, below `reports_warnings`, that also accepts the old spellings of its keywords."""

    @wraps(function)
    def translating(*args: P.args, **kwargs: P.kwargs) -> R:
        for old in RENAMED.keys() & kwargs.keys():
            new = RENAMED[old]
            if new in kwargs:
                raise TypeError(f"{old} is the old spelling of {new}. Give {new} only.")
            warn_deprecated(old, new, 3)
            kwargs[new] = kwargs.pop(old)
        return function(*args, **kwargs)

    return translating


def accepts_deprecated_attributes(kind: C) -> C:
    """Decorate a class whose attributes also have the old names of `ATTRIBUTES`."""
    for old, new in ATTRIBUTES[kind.__name__].items():
        setattr(kind, old, _deprecated_attribute(kind.__name__, old, new))
    return kind


def _deprecated_attribute(kind: str, old: str, new: str) -> property:
    def get(self: Any) -> Any:
        warn_deprecated(f"{kind}.{old}", new)
        return getattr(self, new)

    return property(get, doc=f"The deprecated name of `{new}`.")


def present_class(name: str) -> str:
    """The present name of a class of `sarrus`."""
    if name in CLASSES:
        warn_deprecated(f"sarrus.{name}", CLASSES[name], 3)
    return CLASSES.get(name, name)


def present_name(name: str, known: Container[str]) -> str:
    """The present spelling of the name of a coordinate or output, if that one is known and the given one is not."""
    present = name
    for old, new in OUTPUTS.items():
        present = old.sub(new, present)
    if name in known or present not in known:
        return name
    warn_deprecated(name, present, 3)
    return present


def with_present_types(data: Any, known: Container[str] = ()) -> None:
    """Replace other names, and old ones, of types of joints, drivers and forces of a file, unless they are known."""
    sections = [data.get(key) for key in ("joints", "drivers", "forces")] if isinstance(data, dict) else []
    for section in sections:
        for part in section.values() if isinstance(section, dict) else ():
            if not isinstance(part, dict) or not isinstance(old := part.get("type"), str):
                continue
            if old in TYPES:
                warn_deprecated(f"type: {old}", f"type: {TYPES[old]}", 3)
            if old not in known:
                other = "rsda" if old == "spring" and "axis" in part else OTHER_NAMES.get(old, old)
                part["type"] = TYPES.get(old, other)
