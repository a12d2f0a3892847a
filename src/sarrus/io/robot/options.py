"""The options of an import."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias

from ...model.errors import ModelError
from ...model.show import show

Base: TypeAlias = Literal["fixed", "floating"]
MimicOption: TypeAlias = Literal["couple", "free", "lock"]
InertiaOption: TypeAlias = Literal["check", "given"]

CHOICES = {
    "base": ("fixed", "floating"),
    "mimic": ("couple", "free", "lock"),
    "inertia": ("check", "given"),
}


@dataclass(frozen=True)
class ImportOptions:
    """The options of an import; see `sarrus.load_urdf`."""

    base: Base = "fixed"
    q0: Mapping[str, Any] = field(default_factory=dict)
    lock: Sequence[str] = ()
    mimic: MimicOption = "couple"
    inertia: InertiaOption = "check"
    keep_fixed: bool = False

    def check(self) -> None:
        """Raise a ModelError for a word that is none of the choices."""
        for name, right in CHOICES.items():
            given = getattr(self, name)
            if given not in right:
                message = (
                    f"{name} must be one of {', '.join(right)}, but is {show(given)}; choose one of them"
                )
                raise ModelError(message, part="import", field=name)
