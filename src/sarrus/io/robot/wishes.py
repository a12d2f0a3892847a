"""What a person wants of an import."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias

from ...model.errors import ModelError
from ...model.show import show

Base: TypeAlias = Literal["fixed", "floating"]
MimicWish: TypeAlias = Literal["couple", "free", "lock"]
InertiaWish: TypeAlias = Literal["check", "given"]

CHOICES = {
    "base": ("fixed", "floating"),
    "mimic": ("couple", "free", "lock"),
    "inertia": ("check", "given"),
}


@dataclass(frozen=True)
class Wishes:
    """The options of an import; see `sarrus.load_urdf`."""

    base: Base = "fixed"
    q0: Mapping[str, Any] = field(default_factory=dict)
    lock: Sequence[str] = ()
    mimic: MimicWish = "couple"
    inertia: InertiaWish = "check"
    keep_fixed: bool = False

    def check(self) -> None:
        """Raise a ModelError for a word that is none of the choices."""
        for name, right in CHOICES.items():
            given = getattr(self, name)
            if given not in right:
                told = f"{name} must be one of {', '.join(right)}, but is {show(given)}; choose one of them"
                raise ModelError(told, part="import", field=name)
