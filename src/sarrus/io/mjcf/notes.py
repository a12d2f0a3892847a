"""What an MJCF says and the model does not, in sentences."""

from __future__ import annotations

from typing import Any

import numpy as np

PER_FREEDOM = {
    "dof_damping": "damping of {n} joint freedoms is left out",
    "dof_frictionloss": "dry friction of {n} joint freedoms is left out",
    "dof_armature": "armature of {n} joint freedoms is left out: the mass matrix is that of the bodies",
}
COUNTS = {
    "nu": "{n} actuators are left out",
    "ntendon": "{n} tendons are left out",
    "ngeom": "{n} shapes are kept for drawing: there is no contact",
}


def notes(compiled: Any) -> list[str]:
    """Return one sentence for each kind of thing that is left out."""
    counts = {told: int(np.count_nonzero(getattr(compiled, key))) for key, told in PER_FREEDOM.items()}
    counts["springs of {n} joints are left out"] = int(np.count_nonzero(compiled.jnt_stiffness))
    counts["limits of {n} joints are kept, not enforced"] = int(np.count_nonzero(compiled.jnt_limited))
    counts |= {told: int(getattr(compiled, key)) for key, told in COUNTS.items()}
    return [told.format(n=n) for told, n in counts.items() if n]
