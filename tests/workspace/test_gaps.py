"""Curves that meet at a node miss each other by round-off: a ray through the gap must not change what is inside."""

import numpy as np
import pytest

from sarrus.analyses.workspace.regions.arc import Arc
from sarrus.analyses.workspace.regions.arrangement import Cells, divide

GAP = 1e-9


def quarter(k: int, radius: float, gap: np.ndarray) -> Arc:
    """A quarter of a circle, as an interpolating quintic, moved up by a gap that goes from one end to the other."""
    tau = np.linspace(0, 1, 6)
    angle = (k + tau) * np.pi / 2
    points = radius * np.stack([np.cos(angle), np.sin(angle)], 1)
    points[:, 1] += gap[0] + tau * (gap[1] - gap[0])
    return Arc(np.linalg.solve(tau[:, None] ** np.arange(6), points)[None])


def ring(seed: int) -> Cells:
    """Two circles about the origin, each of four curves whose ends are somewhere within the gap."""
    random = np.random.default_rng(seed)
    gaps = GAP * random.uniform(-1, 1, (2, 4, 2))
    return Cells(divide([quarter(k, (1.0, 0.4)[n], gaps[n, k]) for n in range(2) for k in range(4)]))


@pytest.mark.parametrize("seed", range(20))
def test_rays_through_gaps(seed: int) -> None:
    cells = ring(seed)
    x = np.array([-2, -0.7, 0.0, 0.7, 2])
    y = np.linspace(-GAP, GAP, 201)
    points = np.stack([np.tile(x, len(y)), np.repeat(y, len(x))], axis=1)
    areas = np.array([cell.area for cell in cells.cells])[cells.locate(points)].reshape(-1, len(x))
    assert np.allclose(areas, np.pi * np.array([-1, 0.84, 0.16, 0.84, -1]), atol=1e-4)


@pytest.mark.parametrize("seed", range(20))
def test_inner_points(seed: int) -> None:
    cells = ring(seed)
    for k, cell in enumerate(cells.cells):
        point = cells.inner_point(k) if cell.bounded else None
        assert point is None or cells.locate(point[None])[0] == k
