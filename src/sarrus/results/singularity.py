"""Singular configurations that were found along a motion."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from ..algebra import Array
from .result import WarningSequence


@dataclass(frozen=True)
class Singularity:
    """A singular configuration, in which constraints or inputs of a mechanism lose rank.

    Attributes
    ----------
    at : time [s], or parameter of the path
    q : (nq,)
    kind : "branch": the constraints become dependent and motions meet. "dead centre": the rates of the inputs are zero
        while the mechanism moves, so that they do not determine its motion.
    smallest : smallest singular value there, of equations scaled to unit gradients
    message : one message
    """

    at: float
    q: Array = field(repr=False)
    kind: Literal["branch", "dead centre"]
    smallest: float
    message: str


class Singularities(WarningSequence, tuple[Singularity, ...]):
    """Singular configurations in the order of a path."""
