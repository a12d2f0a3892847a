"""A body whose inertia is taken as the description gives it, even where no mass distribution could have it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...model.body import Body, MassProperties
from ...model.quantity import positive, vector


@dataclass(frozen=True, eq=False)
class GivenBody(Body):
    """A body without the checks of its inertia; its mass is still checked."""

    def mass_properties(self) -> MassProperties:
        """Return the mass, inertia and centre of mass."""
        mass = positive(self.mass, "mass", "give the mass in kg")
        J = np.array(self.inertia, dtype=float)
        xx, yy, zz, xy, xz, yz = (float(J[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
        center = vector(
            (0.0, 0.0, 0.0) if self.center_of_mass is None else self.center_of_mass, "center_of_mass"
        )
        return MassProperties(mass, (xx, yy, zz, xy, xz, yz), center)
