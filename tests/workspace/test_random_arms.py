"""Random planar arms with random limits: what their maps contain is what inverse kinematics in closed form reaches."""

import numpy as np
import pytest
from tests.workspace.mechanisms import arm

import sarrus as sr

TURN = 2 * np.pi
Limits = tuple[float, float]


def within(angle: np.ndarray, limits: Limits) -> np.ndarray:
    """True where an angle or one that differs by whole turns lies between limits."""
    first = angle + TURN * np.ceil((limits[0] - angle) / TURN)
    return first <= limits[1]


def two_links(x: np.ndarray, base: float, lengths: np.ndarray, limits: list[Limits]) -> np.ndarray:
    """Whether two links reach points (n, 2), seen from their base, which is turned by an angle."""
    cosine = ((x**2).sum(axis=1) - (lengths**2).sum()) / (2 * lengths[0] * lengths[1])
    found = np.zeros(len(x), dtype=bool)
    for bend in (1, -1):
        q2 = bend * np.arccos(np.clip(cosine, -1, 1))
        q1 = np.arctan2(x[:, 1], x[:, 0]) - np.arctan2(
            lengths[1] * np.sin(q2), lengths[0] + lengths[1] * np.cos(q2)
        )
        found |= (abs(cosine) <= 1) & within(q2, limits[1]) & within(q1 - base, limits[0])
    return found


def reached(x: np.ndarray, lengths: np.ndarray, limits: list[Limits]) -> np.ndarray:
    """Whether an arm of two or three links reaches points; the first of three links is turned in small steps."""
    if len(lengths) == 2:
        return two_links(x, 0.0, lengths, limits)
    found = np.zeros(len(x), dtype=bool)
    for q1 in np.linspace(*limits[0], 1200):
        elbow = lengths[0] * np.array([np.cos(q1), np.sin(q1)])
        found |= two_links(x - elbow, q1, lengths[1:], limits[1:])
    return found


def to_boundary(x: np.ndarray, lines: list[np.ndarray]) -> float:
    """The distance of a point to polylines."""
    a, b = (np.concatenate([line[part] for line in lines]) for part in (slice(None, -1), slice(1, None)))
    d = b - a
    along = np.clip(((x - a) * d).sum(axis=1) / np.maximum((d * d).sum(axis=1), 1e-300), 0, 1)
    return float(np.linalg.norm(x - a - along[:, None] * d, axis=1).min())


@pytest.mark.slow
@pytest.mark.parametrize(("links", "seed"), [(2, 1), (2, 3), (3, 4)])
def test_what_is_reached(links: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    lengths = random.uniform(0.3, 2.0, links)
    lows = random.uniform(-3.0, 0.5, links)
    limits = [(low, low + random.uniform(0.3, 3.0)) for low in lows]
    system, tip = arm(list(lengths))
    found = sr.workspace(system, tip["x", "y"], limits={f"q{n + 1}": limit for n, limit in enumerate(limits)})
    size = lengths.sum()
    x = random.uniform(-size, size, (8000, 2))
    other = x[found.contains(x) != reached(x, lengths, limits)]
    lines = [loop for part in found.components for loop in part.loops]
    assert all(to_boundary(one, lines) < 2e-3 * size for one in other)
    assert len(other) < 30
