"""What assembly gives back."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..algebra import Array
from .frozen import freeze


@dataclass(frozen=True, eq=False)
class Assembly:
    """Coordinates and velocities that satisfy the constraints, or the best that was found.

    Attributes
    ----------
    q, v : (nq,)
    success : whether the constraints hold within the tolerance
    message : one sentence: how it went, or which joints stay open by how much
    residual : largest entry of |Φ|
    iterations : Newton steps taken
    """

    q: Array = field(repr=False)
    v: Array = field(repr=False)
    success: bool
    message: str
    residual: float
    iterations: int

    def __post_init__(self) -> None:
        freeze(self)
