"""Base class of drivers: a name and primitives whose right-hand sides are functions of time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from ..coordinate import Known
from ..geometry.pose import Poses
from ..primitive import Primitive
from ..registry import Part, register


@dataclass(frozen=True, eq=False)
class Driver(Part, ABC):
    """Base class of drivers (prescribed motions); a subclass is a frozen dataclass that yields primitives.

    In a model file its type is the class name without "Driver".
    """

    kinds: ClassVar[dict[str, type[Driver]]] = {}

    name: str

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        register(cls, Driver.kinds)

    @abstractmethod
    def primitives(self, poses: Poses, known: Known) -> Iterator[Primitive]:
        """Yield the primitives for the given initial poses and coordinates of joints."""
