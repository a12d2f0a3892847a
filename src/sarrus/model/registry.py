"""Kinds of joints, forces and drivers register themselves when their class is made."""

from __future__ import annotations

import re
from typing import TypeVar

Kind = TypeVar("Kind")


def register(cls: type[Kind], kinds: dict[str, type[Kind]]) -> None:
    """Enter ``cls`` under the name that a model file gives as its ``type``."""
    name = kind_name(cls)
    if name in kinds and kinds[name].__module__ != cls.__module__:
        raise TypeError(
            f"{cls.__module__} and {kinds[name].__module__} both define the type {name!r}. Rename one of the classes."
        )
    kinds[name] = cls


def kind_name(cls: type) -> str:
    """Return ``point_force`` for PointForce, ``tsda`` for TSDA, ``angle`` for AngleDriver."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "_", cls.__name__.removesuffix("Driver")).lower()
