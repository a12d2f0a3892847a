"""Kinds of joints, forces and drivers register themselves when their class is made; and how a part is shown."""

from __future__ import annotations

import re
from dataclasses import MISSING, fields
from inspect import cleandoc
from reprlib import recursive_repr
from typing import Any, ClassVar, TypeVar

import numpy as np

from .checks.calls import CallCheck
from .errors import ModelError
from .parity import Parities
from .show import quote

TITLE = "\n\nParameters\n----------\n"
SECTION = re.compile(r"\n\n(?=\w[\w ]*\n-{3,}\n)")
ENTRY = re.compile(
    r"^(\w[\w, ]*).*(?:\n[ ]+.*)*", re.MULTILINE
)  # names, and a text behind them or indented below


def described(cls: type) -> str:
    """The docstring of a class whose parameters are followed by those that its base classes describe.

    A parameter is described once, by the first class in the order of inheritance.
    """
    before, entries, after = _parts(cls)
    for base in cls.__mro__[1:]:
        entries |= {names: text for names, text in _parts(base)[1].items() if names not in entries}
    return before + (TITLE + "\n".join(entries.values()) if entries else "") + after


def _parts(cls: type) -> tuple[str, dict[str, str], str]:
    """What comes before the parameters, their entries by names, and the sections behind."""
    first, *sections = SECTION.split(cleandoc(cls.__dict__.get("__doc__") or ""))
    titled = {section.partition("\n")[0]: section for section in sections}
    body = titled.pop("Parameters", "").partition("-\n")[2]
    entries = {entry[1].strip(): entry[0] for entry in ENTRY.finditer(body)}
    return first, entries, "".join(f"\n\n{section}" for section in titled.values())


PLAIN = ("name", "body", "body_i", "body_j")  # fields that are shown without their names
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
    """Return ``point_force`` for PointForce, ``tsda`` for TSDA, ``dc_motor`` for DCMotor, ``angle`` for AngleDriver."""
    return re.sub(
        r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", cls.__name__.removesuffix("Driver")
    ).lower()


@recursive_repr()
def shown(part: Any) -> str:
    """Return ``Revolute('pin', ground, crank, axis=(1, 0, 0))``, bodies by name, without defaults."""
    found = []
    for field in sorted(fields(part), key=lambda one: one.kw_only is True):
        value = getattr(part, field.name, MISSING)
        value = value.tolist() if isinstance(value, np.ndarray) else value  # on one line
        text = str(value.name) if callable(getattr(value, "global_point", None)) else repr(value)
        default = field.default if field.default_factory is MISSING else field.default_factory()
        if field.repr and value is not MISSING and text != repr(default):
            found.append(text if field.name in PLAIN else f"{field.name}={text}")
    return f"{type(part).__name__}({', '.join(found)})"


class Part(metaclass=CallCheck):
    """A joint, driver or force. It is shown as `shown` does unless its class has a line of its own."""

    __repr__ = shown
    parity: ClassVar[Parities] = {}

    def __post_init__(self) -> None:
        """Refuse one of two bodies, unless frames or points on bodies are given."""
        bodies = [getattr(self, name, self) for name in ("body_i", "body_j")]
        others = [getattr(self, name, None) for name in ("frame_i", "frame_j", "point_i", "point_j")]
        if sum(body is None for body in bodies) == 1 and all(other is None for other in others):
            part = f"{type(self).__name__} {quote(getattr(self, 'name', ''))}"
            message = "one of its two bodies is missing. Name the two bodies it connects."
            raise ModelError(message, part=part, field="body_i")

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        cls.__doc__ = described(cls)
        inherited: object = cls.__repr__
        if inherited is shown:
            cls.__repr__ = shown  # type: ignore[assignment, method-assign]  # dataclasses would write bodies within points
