"""The physical quantity of a numeric field: a declaration beside the field's type.

``mass: Annotated[float, In("kg")]`` declares that a model file may give the mass in any unit of mass, and
that a formula for it must not have the unit metre.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, TypeAlias

from .quantity import Vector


@dataclass(frozen=True)
class In:
    """The SI unit of a field.

    Parameters
    ----------
    unit
        SI base units and N with powers, at most one ``/``: ``kg m^2``, ``N s/m``, ``rad``; ``1`` for a plain number.
    over
        For a field that may be a table: the unit of the table's first column.
    named
        Whether the name of a point of the model file may stand for the numbers.
    """

    unit: str
    over: str = "1"
    named: bool = False


Mass: TypeAlias = Annotated[float, In("kg")]
Length: TypeAlias = Annotated[float, In("m")]
Angle: TypeAlias = Annotated[float, In("rad")]
Place: TypeAlias = Annotated[Vector, In("m", named=True)]  # a global point
Offset: TypeAlias = Annotated[Vector, In("m")]  # in body axes
Direction: TypeAlias = Annotated[Vector, In("1")]
Velocity: TypeAlias = Annotated[Vector, In("m/s")]
AngularVelocity: TypeAlias = Annotated[Vector, In("rad/s")]
Acceleration: TypeAlias = Annotated[Vector, In("m/s^2")]
ForceVector: TypeAlias = Annotated[Vector, In("N")]
TorqueVector: TypeAlias = Annotated[Vector, In("N m")]
Ratio: TypeAlias = Annotated[float, In("1")]
