"""What the numbers of a model are called."""

import numpy as np

import sarrus as sr
from sarrus.model.written import with_numbers, written_numbers


def test_matrices_of_bushings_count_their_entries() -> None:
    """From 1 to 6 in both directions: the third entry of a row was called z, the fourth 4."""
    body = sr.Body("block", mass=1.0, inertia=((2, 0.1, 0), (0.1, 2, 0), (0, 0, 2)))
    mount = sr.Bushing(
        "mount", sr.ground, body, (0, 0, 0), stiffness=np.diag(range(1, 7)), damping=range(6), preload=[0] * 6
    )
    model = sr.Model("mounted", bodies=[body], forces=[mount])
    known = written_numbers(model)
    assert [known[f"mount.stiffness.{k}.{k}"] for k in range(1, 7)] == [1, 2, 3, 4, 5, 6]
    assert [known[f"mount.damping.{k}"] for k in range(1, 7)] == [0, 1, 2, 3, 4, 5]
    assert "mount.preload.6" in known
    assert known["block.inertia.x.y"] == 0.1
    assert written_numbers(with_numbers(model, {"mount.stiffness.6.3": 0.5}))["mount.stiffness.6.3"] == 0.5
