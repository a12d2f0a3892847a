"""The bodies of a robot: body frames are link frames, and an inertia may be taken as it is given."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...algebra import Array
from ...model.bodies.body import Body, MassProperties
from ...model.errors import ModelError
from ...model.geometry.pose import Pose
from ...model.quantity import positive, vector
from ...model.show import quote
from .description import MASSLESS, Description, Edge, Inertial
from .options import InertiaOption
from .tree.merge import Merged


def bodies_of(
    description: Description,
    inertia: InertiaOption,
    merged: Merged,
    names: Mapping[str, str],
    poses: Mapping[str, Pose],
) -> tuple[Body, ...]:
    """Return a checked body for every link that heads others.

    Raises
    ------
    ModelError
        If nothing moves, or a body has an inertia that no body can have.
    """
    if not merged.edges:
        urdf = description.file.lower().endswith(".urdf")
        remedy = 'Import it with base="floating", or give it' if urdf else "Give a body"
        message = f"nothing in it moves. {remedy} a joint that moves."
        raise ModelError(message, part="robot", where=description.file)
    bodies = []
    for edge in merged.edges:
        name, inertial = names[edge.child], _inertial(merged, edge)
        kind = Body if inertia == "check" or inertial is MASSLESS else GivenBody
        try:
            body = _body(kind, name, inertial, poses[name])
            body.mass_properties()
        except ModelError as error:
            checked = error.field == "inertia" and inertia == "check"
            remedy = ' Or take it as it is: inertia="given".' if checked else ""
            part, where = f"link {quote(edge.child)}", description.where(description.line_of(edge))
            raise ModelError(error.message + remedy, part=part, field=error.field, where=where) from None
        bodies.append(body)
    return tuple(bodies)


def _body(kind: type[Body], name: str, inertial: Inertial, pose: Pose) -> Body:
    return kind(name, inertial.mass, inertial.tensor, pose.r, pose.p, inertial.center)


def _inertial(merged: Merged, edge: Edge) -> Inertial:
    """Return the inertial of a link with what is fixed to it; without mass it is a frame between joints."""
    inertial = merged.inertials.get(edge.child)
    return inertial if inertial is not None and inertial.mass else MASSLESS


ROUND_OFF = 1e-9  # of the largest moment: a negative moment that comes from rounded numbers
GYRATION = 1e-6  # [m] radius of gyration of such a moment where the others are zero, too


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
        mass = positive(self.mass, "mass", "Give the mass in kg.")
        J = np.array(self.inertia, dtype=float)
        _check_not_negative(J, mass)
        xx, yy, zz, xy, xz, yz = (float(J[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
        center = (0.0, 0.0, 0.0) if self.center_of_mass is None else self.center_of_mass
        return MassProperties(mass, (xx, yy, zz, xy, xz, yz), vector(center, "center_of_mass"))


def _check_not_negative(J: Array, mass: float) -> None:
    moments = np.linalg.eigvalsh(J) if np.all(np.isfinite(J)) else np.full(3, np.nan)
    if not moments[0] >= -max(ROUND_OFF * abs(moments).max(), mass * GYRATION**2):
        message = ", ".join(f"{moment:.6g}" for moment in moments)
        raise ModelError(
            f"inertia has the principal moments {message}, but a negative one gives a negative kinetic energy. "
            "Correct the inertia.",
            field="inertia",
        )
