"""Base class of forces: a name and primitives. It contains no formula of mechanics."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from ...elements import Element
from ..errors import ModelError
from ..geometry.pose import Poses
from ..geometry.solid import GROUND
from ..primitive import Primitive
from ..registry import Part, register


@dataclass(frozen=True, eq=False)
class Force(Part, ABC):
    """Base class of forces and torques; a subclass is a frozen dataclass that yields its elements."""

    kinds: ClassVar[dict[str, type[Force]]] = {}

    name: str

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        register(cls, Force.kinds)

    @abstractmethod
    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the primitives for the given initial poses."""


def refuse_ground(body: str, field: str) -> None:
    """Raise a ModelError if a load on one body is put on the ground."""
    if body == GROUND:
        raise ModelError("acts on the ground, which does not move. Name a body of the model.", field=field)


def choose(axes: object, *, of_global: type[Element], of_body: type[Element]) -> type[Element]:
    """Return the element for a load that is given in global or in body axes."""
    if axes == "global":
        return of_global
    if axes == "body":
        return of_body
    raise ModelError(f'axes must be "global" or "body", but is {axes!r}. Choose one of them.', field="axes")
