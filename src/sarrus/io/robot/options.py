"""The options of an import, with the values of joints by name, checked."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from ...model.errors import ModelError
from ...model.geometry.motion import Free, Motion
from ...model.laws.law import Law
from ...model.quantity import Array, number, numbers
from ...model.show import quote, show, suggest
from .description import Edge

Base: TypeAlias = Literal["file", "fixed", "floating"]
MimicOption: TypeAlias = Literal["couple", "free", "lock"]
InertiaOption: TypeAlias = Literal["check", "given"]
MeshOption: TypeAlias = Literal["draw", "ignore"]

CHOICES = {
    "base": get_args(Base),
    "mimic": get_args(MimicOption),
    "inertia": get_args(InertiaOption),
    "meshes": get_args(MeshOption),
}


MJCF_ALONE = ("contacts", "equalities", "flex", "joints", "limits", "plugins", "tendons")
SDF_ALONE = ("decay", "includes", "kinematic")
IGNORABLE = (
    "actuators",
    "dynamics",
    "fluid",
    *MJCF_ALONE,
    *SDF_ALONE,
)  # all formats have all words of ``ignore``


@dataclass(frozen=True)
class ImportOptions:
    """The options of an import; see `sarrus.load_urdf`."""

    base: Base = "fixed"
    q0: Mapping[str, ArrayLike] = field(default_factory=dict)
    lock: Sequence[str] = ()
    mimic: MimicOption = "couple"
    inertia: InertiaOption = "check"
    keep_fixed: bool = False
    ignore: Sequence[str] = ()
    controls: Mapping[str, Law] = field(default_factory=dict)
    meshes: MeshOption = "draw"
    search: Sequence[str | os.PathLike[str]] = ()

    def check(self, actuators: Iterable[str]) -> None:
        """Raise a ModelError for a word that is no choice, or that ``ignore`` or ``controls`` cannot have."""
        for name, right in CHOICES.items():
            choice = getattr(self, name)
            if choice not in right:
                message = (
                    f"{name} must be one of {', '.join(right)}, but is {show(choice)}. Choose another one."
                )
                raise ModelError(message, part="import", field=name)
        for folder in self.search:
            if not Path(folder).is_dir():
                message = f"search has {folder}, which is no folder. Correct or remove it."
                raise ModelError(message, part="import", field="search")
        _check_words("ignore", self.ignore, IGNORABLE)
        _check_words("controls", self.controls, actuators)


def check_floating(base: Base, edges: Iterable[Edge]) -> None:
    """Raise a ModelError if the root is to move freely, but joints connect all links with the world."""
    if base == "floating" and not any(isinstance(motion, Free) for edge in edges for motion in edge.motions):
        message = 'base is "floating", but joints connect all bodies with the world. Choose "file".'
        raise ModelError(message, part="import", field="base")


def _check_words(field: str, given: Iterable[str], known: Iterable[str]) -> None:
    words = sorted(known)
    for word in given:
        if word not in words:
            message = f"{field} cannot have {show(word)}. {suggest(str(word), words, len(words))}"
            raise ModelError(message, part="import", field=field)


def known(name: str, names: Iterable[str], field: str) -> str:
    """Return the name, or raise a ModelError with a suggestion if there is no such joint that moves."""
    right = list(names)
    if name not in right:
        message = f"{field} names {quote(str(name))}, but no joint that moves has this name"
        raise ModelError(f"{message}. {suggest(str(name), right)}", field=field)
    return name


def values_of(given: Mapping[str, Any], motions: Mapping[str, Motion], field: str) -> dict[str, Array]:
    """Return the checked values by motion."""
    return {
        name: _values(motions[known(name, motions, field)], value, field) for name, value in given.items()
    }


def _values(motion: Motion, value: Any, field: str) -> Array:
    label = f"{field} of {quote(motion.name)}"
    if motion.width == 1:
        return np.array([number(value, label, "Give an angle in rad or a displacement in m.")])
    values = np.array(
        numbers(value, motion.width, label, f"Give {motion.width} numbers, {_ORDER[motion.width]}.")
    )
    if not np.linalg.norm(values[-4:]):
        raise ModelError(
            f"{label} has Euler parameters of zero length. Give [1, 0, 0, 0] for no turn.", field=field
        )
    return values


_ORDER = {4: "the Euler parameters", 7: "position and Euler parameters"}
