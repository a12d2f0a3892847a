"""Base class of forces: a name and primitives. It contains no formula of mechanics."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from ..coordinates import CoordinateBlock
from ..errors import ModelError
from ..geometry.points import GROUND, refuse_other_axes
from ..geometry.pose import Poses
from ..primitive import Primitive
from ..quantity import Vec3
from ..registry import Part, register
from ..signals import Signals

Kind = TypeVar("Kind")


@dataclass(frozen=True, eq=False)
class Force(Part):
    """Base class of forces and torques; a subclass is a frozen dataclass that yields its elements.

    ``Force("name", ...)`` creates a force by a formula of outputs and the time, between two points or along a joint:
    ``Force("jack", base.point(0, 0, 0), ram.point(0, 0, 0), value="p*A - c*v", parameters={"p": 6, "A": 1, "c": 2})``,
    ``Force("jack", "slide", value="6 - 2*v")``, see `sarrus.model.forces.by_formula.Force`.
    """

    kinds: ClassVar[dict[str, type[Force]]] = {}

    name: str

    if TYPE_CHECKING:

        def __init__(self, name: str, *args: Any, **given: Any) -> None: ...

    @classmethod
    def constructed(cls) -> type[Force]:
        """The class itself, or that of forces by formulas for `Force` itself."""
        return cls.kinds["force"] if cls is Force else cls

    def __new__(cls, *args: Any, **given: Any) -> Any:
        """Return an object of that class."""
        return super().__new__(cls.constructed())

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if cls.primitives is Force.primitives and cls.relations is Force.relations:
            raise TypeError(
                f"{cls.__name__}: its elements are missing. Write a method primitives that yields them."
            )
        register(cls, Force.kinds)

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the primitives for the given poses of the design position."""
        yield from ()

    def weight(self, poses: Poses, gravity: Vec3) -> Iterator[Primitive]:
        """Yield the weight of a force that has mass, where there is gravity."""
        yield from ()

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the primitives that need the outputs of other parts."""
        yield from ()

    def variables(self) -> Iterator[tuple[str, Any]]:
        """Yield its outputs that are formulas, which others may use: name, and a function that records it."""
        yield from ()

    def blocks(self) -> Iterator[CoordinateBlock]:
        """Yield the blocks of coordinates that it adds, to which its elements give inertia."""
        yield from ()

    def states(self) -> Iterator[Any]:
        """Yield its first-order states, see `sarrus.model.states`; their rates are among its relations."""
        yield from ()


def refuse_ground(body: str, field: str) -> None:
    """Raise a ModelError if a load on one body is put on the ground."""
    if body == GROUND:
        raise ModelError("acts on the ground, which does not move. Name a body of the model.", field=field)


def choose(axes: object, *, of_global: Kind, of_body: Kind) -> Kind:
    """Return the element, or the Q, for a load that is given in global or in body axes."""
    refuse_other_axes(axes)
    return of_global if axes == "global" else of_body
