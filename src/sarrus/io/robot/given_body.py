"""A body whose inertia is taken as the description gives it, even where no mass distribution could have it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...algebra import Array
from ...model import ModelError
from ...model.bodies.body import Body, MassProperties
from ...model.quantity import positive, vector

ROUND_OFF = 1e-9  # of the largest moment: a negative moment that comes from rounded numbers


@dataclass(frozen=True, eq=False)
class GivenBody(Body):
    """A body whose inertia need not be that of a distribution of mass, but may not be negative about any axis."""

    def mass_properties(self) -> MassProperties:
        """Return the mass, inertia and centre of mass.

        Raises
        ------
        ModelError
            If a principal moment is negative or no number: some rotation would have a negative kinetic energy.
        """
        mass = positive(self.mass, "mass", "give the mass in kg")
        J = np.array(self.inertia, dtype=float)
        _check_not_negative(J)
        xx, yy, zz, xy, xz, yz = (float(J[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
        center = vector(
            (0.0, 0.0, 0.0) if self.center_of_mass is None else self.center_of_mass, "center_of_mass"
        )
        return MassProperties(mass, (xx, yy, zz, xy, xz, yz), center)


def _check_not_negative(J: Array) -> None:
    moments = np.linalg.eigvalsh(J) if np.all(np.isfinite(J)) else np.full(3, np.nan)
    if not moments[0] >= -ROUND_OFF * abs(moments).max():
        message = ", ".join(f"{moment:.6g}" for moment in moments)
        raise ModelError(
            f"inertia has the principal moments {message}, but a negative one gives a negative kinetic energy. "
            "Correct the inertia.",
            field="inertia",
        )
