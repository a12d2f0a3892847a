"""Dry friction in a joint under a given load, after Stribeck."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Annotated

from ... import elements
from ..geometry.placement import AboutAxis
from ..geometry.pose import Poses
from ..measure import In, Length, Ratio
from ..primitive import Primitive
from ..quantity import not_negative, positive
from .force import Force


@dataclass(frozen=True, eq=False, kw_only=True)
class DryFriction:
    """Friction load · [μ + (μ_s − μ) exp(−(u/stribeck)²)] tanh(u/creep) + viscous · u against the sliding speed u.

    Parameters
    ----------
    load
        Normal load [N], constant: the joint's reaction is not used, so where it varies much, so does the error.
    mu
        Coefficient of sliding friction μ.
    mu_static
        Coefficient of sticking friction μ_s; left out, it is ``mu``.
    stribeck
        [m/s] Speed over which one falls to the other.
    creep
        [m/s] Speed of regularization: what would stick creeps, the slower the smaller this is.
    viscous
        [N s/m]
    """

    load: Annotated[float, In("N")]
    mu: Ratio
    mu_static: Ratio | None = None
    stribeck: Annotated[float, In("m/s")] = 1e-2
    creep: Annotated[float, In("m/s")] = 1e-3
    viscous: Annotated[float, In("N s/m")] = 0.0

    def friction(self) -> tuple[float, ...]:
        """Return the checked numbers in the elements' order."""
        mu = not_negative(self.mu, "mu", "Give the coefficient of friction.")
        mu_static = (
            mu if self.mu_static is None else not_negative(self.mu_static, "mu_static", "Give a coefficient.")
        )
        return (
            not_negative(self.load, "load", "Give the normal load in N."),
            mu,
            mu_static,
            positive(self.stribeck, "stribeck", "Give a speed in m/s."),
            positive(self.creep, "creep", "Give a small speed in m/s."),
            not_negative(self.viscous, "viscous", "Give it in N s/m."),
        )


@dataclass(frozen=True, eq=False)
class AngleFriction(DryFriction, AboutAxis, Force):
    """Dry friction of a pin of ``radius`` [m] in a revolute joint; its position is given as that of the joint."""

    radius: Length = field(kw_only=True)

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the friction."""
        i, j = self.frames(poses)
        radius = positive(self.radius, "radius", "Give the pin's radius in m.")
        yield Primitive(elements.AngleFriction, (i.body, j.body), (i.h, radius, *self.friction()), "friction")


@dataclass(frozen=True, eq=False)
class DisplacementFriction(DryFriction, AboutAxis, Force):
    """Dry friction in a translational or cylindrical joint; its position is given as that of the joint."""

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the friction."""
        i, j = self.frames(poses)
        yield Primitive(
            elements.DisplacementFriction, (i.body, j.body), (i.h, j.s, *self.friction()), "friction"
        )
