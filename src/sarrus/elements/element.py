"""Elements: records of numbers with kernels, each declared in one class in one file.

A kernel is a method that returns the element's share of one operator, as NumPy blocks in the order r_i, p_i, r_j, p_j
(or r, p for one body), None for a block of zeros. It works for any kind of number and is compiled by recording.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Annotated, Any, ClassVar, NamedTuple, TypeAlias, dataclass_transform

from ..algebra import Array, Row
from .derived import conservative_force, derived
from .follows import ConstraintFollows, InertiaFollows, NonholonomicFollows
from .force_outputs import ForceOutputs
from .operators import (
    CONSTRAINT,
    DERIVATIVES,
    FORCE,
    INERTIA,
    NONHOLONOMIC,
    Axis,
    Derivative,
    Operator,
)
from .output import Declared, declared

Vec3: TypeAlias = Annotated[Array, "Vec3"]
Inertia: TypeAlias = Annotated[Array, "Inertia"]
Scalar: TypeAlias = Annotated[Any, "Scalar"]
Curve: TypeAlias = Annotated[Any, "Curve"]
Surface: TypeAlias = Annotated[Any, "Surface"]
Memory: TypeAlias = Annotated[Any, "Memory"]
Vec6: TypeAlias = Annotated[Array, "Vec6"]
Mat66: TypeAlias = Annotated[Array, "Mat66"]  # 36 numbers, row by row
Time: TypeAlias = Annotated[Any, "Time"]
WIDTHS = {
    "Vec3": 3, "Inertia": 6, "Scalar": 1, "Curve": 1, "Surface": 1, "Memory": 1, "Time": 0, "Vec6": 6, "Mat66": 36
}  # fmt: skip
Grid: TypeAlias = "tuple[Row, ...]"


ZERO_SINGLE: Grid = ((None,) * 2,) * 2
ZERO_PAIR: Grid = ((None,) * 4,) * 4


class Validity(NamedTuple):
    """The range of a quantity in which an element's law holds; a run that leaves it has a warning.

    of : name of the element's method of the coordinates and velocities that returns it
    low, high : the ends
    ends, remedy : texts of the warning before and after its values
    """

    of: str
    low: float
    high: float
    ends: str
    remedy: str


class Kind(NamedTuple):
    """What a block of coordinates is.

    Attributes
    ----------
    name : of the kind
    parts : names of the coordinates
    is_length : whether norms and tolerances divide the coordinates by a length of the system
    ground : coordinates of the fixed body
    """

    name: str
    parts: tuple[str, ...]
    is_length: bool
    ground: tuple[float, ...] = ()

    def scale(self, length: float) -> float:
        """The size of a unit change: the length for displacements and amplitudes, 1 for Euler parameters."""
        return length if self.is_length else 1.0


POSITION = Kind("position", ("r.x", "r.y", "r.z"), True, (0, 0, 0))
ROTATION = Kind("rotation", ("p.e0", "p.e1", "p.e2", "p.e3"), False, (1, 0, 0, 0))
RIGID = (POSITION, ROTATION)  # the blocks of a rigid body


def modal(count: int) -> Kind:
    """The kind of a block of amplitudes of modes, which are displacements."""
    return Kind("modal", tuple(f"w{n + 1}" for n in range(count)), True)


class Pair(NamedTuple):
    """Coordinates of two bodies, or a direction in them: the paper's partition of a 14-vector."""

    r_i: Array
    p_i: Array
    r_j: Array
    p_j: Array


class Single(NamedTuple):
    """Coordinates of one body, or a direction in them."""

    r: Array
    p: Array


class ElementError(TypeError):
    """A user's element class is incomplete."""


@dataclass_transform(frozen_default=True)
class Element:
    """Base of constraint primitives, inertias and forces. Subclasses declare fields and kernels."""

    family: ClassVar[tuple[Operator, ...]] = ()
    bodies: ClassVar[int] = 2
    rows: ClassVar[int] = 0
    fields: ClassVar[dict[str, str]]
    outputs: ClassVar[dict[str, Declared]] = {}
    timed: ClassVar[bool] = False
    rare: ClassVar[bool] = False
    validity: ClassVar[Validity | None] = None
    nonholonomic: ClassVar[bool] = False
    rules: ClassVar[Mapping[str, Derivative]] = DERIVATIVES
    registry: ClassVar[dict[str, type[Element]]] = {}

    def __init_subclass__(
        cls,
        rows: int = 0,
        bodies: int = 0,
        abstract: bool = False,
        derivatives: str = "coded",
        rare: bool = False,
        registered: bool = True,
    ) -> None:
        """`rare` elements are compiled for the systems that have them, not ahead with all others.

        Fields of `abstract` classes are inherited, before a class's own.

        A class that the package creates for one model is not `registered`. The registry is replaced, never changed,
        since other threads may iterate over it.
        """
        dataclasses.dataclass(frozen=True, eq=False)(cls)
        if abstract:
            return
        cls.rare = rare
        if bodies:
            cls.bodies = bodies
        cls.rows = rows
        if issubclass(cls, Primitive) and rows < 1:
            raise ElementError(
                f"element {cls.__name__}: The number of equations is missing. Declare class X(Primitive, rows=1)."
            )
        cls.fields = {f.name: _kind(cls, f) for f in dataclasses.fields(cls)}  # type: ignore[arg-type]
        if "Memory" in cls.fields.values() and not callable(getattr(cls, "remember", None)):
            raise ElementError(
                f"element {cls.__name__}: A Memory field requires a method remember(x). Write one that returns its "
                "new values, or annotate the field as Scalar."
            )
        cls.timed, cls.outputs = "Time" in cls.fields.values(), declared(cls)
        for operator in cls.family:
            automatic = derivatives == "automatic" and not _is_written(cls, operator)
            if operator.origin == "derived" or (automatic and operator.name in DERIVATIVES):
                setattr(cls, operator.name, derived(operator.name))
            elif automatic and operator.name == "Q" and hasattr(cls, "potential"):
                setattr(cls, operator.name, conservative_force)
        missing = [op.name for op in cls.family if not _is_written(cls, op)]
        if missing:
            ways = "Q(x, v, t) or potential(x), and" if "Q" in missing else "one method for each, or"
            raise ElementError(
                f"element {cls.__name__}: {', '.join(missing)} is missing. Write {ways} declare the class with "
                'derivatives="automatic" to derive them by automatic differentiation.'
            )
        if registered:
            Element.registry = {**Element.registry, cls.__name__: cls}

    @classmethod
    def size(cls) -> int:
        """Number of values that the fields hold."""
        return sum(WIDTHS[kind] for kind in cls.fields.values())

    @classmethod
    def owners(cls) -> tuple[tuple[Kind, ...], ...]:
        """The kinds of the blocks that it touches, for each owner: by default those of rigid bodies."""
        return (RIGID,) * cls.bodies

    @classmethod
    def is_body(cls, n: int) -> bool:
        """Whether an owner is a rigid body."""
        return cls.owners()[n] == RIGID

    @classmethod
    def by_owner(cls, blocks: Sequence[Any]) -> list[tuple[Any, ...]]:
        """Blocks of coordinates, or for them, of each owner."""
        ends = [0]
        for kinds in cls.owners():
            ends.append(ends[-1] + len(kinds))
        return [tuple(blocks[first:end]) for first, end in pairwise(ends)]

    @classmethod
    def coordinates(cls) -> tuple[int, ...]:
        """Widths of the blocks of coordinates: 3, 4 (one body) or 3, 4, 3, 4."""
        return tuple(len(kind.parts) for blocks in cls.owners() for kind in blocks)

    @classmethod
    def widths(cls) -> tuple[int, ...]:
        """Widths of the blocks of parameters: one per field."""
        return tuple(WIDTHS[kind] for kind in cls.fields.values())


def _is_written(cls: type[Element], operator: Operator) -> bool:
    """Whether an operator has a kernel. By parameters, one that is written for a class has a block for each of its own
    fields, and is no kernel of a subclass with others.
    """
    writer = next((base for base in cls.__mro__ if operator.name in vars(base)), None)
    kernel = vars(writer)[operator.name] if writer else None
    if not callable(kernel) or Axis.PARAMETERS not in operator.axes:
        return callable(kernel)
    is_derived = kernel.__module__ == derived.__module__
    return is_derived or vars(writer).get("fields", cls.fields) == cls.fields


def _kind(cls: type, field: dataclasses.Field[Any]) -> str:
    """The name under which a field was annotated, also where annotations are not strings."""
    names = getattr(field.type, "__metadata__", (field.type,))
    kind = str(names[0]).rsplit(".", 1)[-1]
    if kind not in WIDTHS:
        raise ElementError(
            f"element {cls.__name__}: {field.name} is annotated with {kind}, which is no kind of a field. "
            f"Choose from {', '.join(WIDTHS)}."
        )
    return kind


class Primitive(ConstraintFollows, Element, abstract=True):
    """A basic constraint: `rows` equations Φ(q) = 0 between two bodies (or for one)."""

    family = tuple(CONSTRAINT)


class Nonholonomic(NonholonomicFollows, Primitive, abstract=True):
    """A constraint on velocities: `rows` equations Φ_q(q) v = 0 that are no derivative of equations Φ(q) = 0.

    Subclasses write ``Phi_q_xi(x, xi)``, which is linear in ξ; their derivatives are automatic.
    """

    nonholonomic = True
    rules = NONHOLONOMIC


class InertiaElement(InertiaFollows, Element, abstract=True):
    """Mass matrix and quadratic velocity force of one body."""

    family = tuple(INERTIA)
    bodies = 1


class Force(ForceOutputs, Element, abstract=True):
    """A generalized force Q(q, v, t), with its derivatives."""

    family = tuple(FORCE)
