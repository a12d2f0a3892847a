"""Notes on what an MJCF contains and the model does not."""

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
    "ngeom": "{n} shapes are used for drawing only: there is no contact",
}


def notes(compiled: Any) -> list[str]:
    """Return one message for each kind of thing that is left out."""
    counts = {message: int(np.count_nonzero(getattr(compiled, key))) for key, message in PER_FREEDOM.items()}
    counts["springs of {n} joints are left out"] = int(np.count_nonzero(compiled.jnt_stiffness))
    counts["limits of {n} joints are stored, not enforced"] = int(np.count_nonzero(compiled.jnt_limited))
    counts |= {message: int(getattr(compiled, key)) for key, message in COUNTS.items()}
    return [message.format(n=n) for message, n in counts.items() if n]
