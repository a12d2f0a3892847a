"""Limits at singular configurations: an elbow that is stretched or folded at its limit; areas in closed form."""

import numpy as np
import pytest

import sarrus as sr

from .mechanisms import arm

PI = np.pi


def area(lengths: tuple[float, float], q1: tuple[float, float], q2: tuple[float, float]) -> float:
    """Of one way to bend the elbow: less than a turn of q1, q2 on one side of zero."""
    return float((q1[1] - q1[0]) * lengths[0] * lengths[1] * abs(np.cos(q2[0]) - np.cos(q2[1])))


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("lengths", "q1", "q2"),
    [
        ((1, 0.7), (-1, 2), (0, 2)),
        ((1, 0.7), (-1, 2), (-2, 0)),
        ((1, 0.7), (-1, 2), (0, PI)),
        ((1, 0.7), (-1, 2), (-PI, -0.5)),
        ((0.7, 1), (-1, 2), (0, PI)),
        ((1, 0.7), (-PI, PI), (0, 2)),
        ((1, 1), (-1, 2), (0, PI)),
        ((1, 1), (-PI, PI), (0, 2)),
    ],
)
def test_a_limit_at_a_stretched_or_folded_elbow(
    lengths: tuple[float, float], q1: tuple[float, float], q2: tuple[float, float]
) -> None:
    """The multiplier of such a limit vanishes all along its curve: round-off told its open side."""
    system, tip = arm(list(lengths))
    found = sr.workspace(system, tip["x", "y"], limits={"q1": q1, "q2": q2}, samples=200, rays=10)
    assert found.success
    assert found.area == pytest.approx(area(lengths, q1, q2), rel=1e-6)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("beyond", [1e-9, 1e-6, 1e-4, 3e-3])
def test_a_limit_a_little_beyond_a_stretched_elbow(beyond: float) -> None:
    """Both curves are nearer to each other than a node of the plane's division."""
    system, tip = arm([1, 0.7])
    limits = {"q1": (-1, 2), "q2": (-beyond, 2)}
    found = sr.workspace(system, tip["x", "y"], limits=limits, samples=200, rays=10)
    assert found.success
    assert found.area == pytest.approx(area((1, 0.7), (-1, 2), (0, 2)), rel=1e-6)


def test_equal_limits_keep_a_value() -> None:
    system, tip = arm([1, 0.5, 0.4])
    limits = {"q1": (-1, 2), "q2": (0.2, 1.5), "q3": (0.3, 0.3)}
    found = sr.workspace(system, tip["x", "y"], limits=limits, samples=200, rays=10)
    link = 0.5 + 0.4 * np.exp(0.3j)
    turned = float(np.angle(link))
    exact = area((1, float(abs(link))), (-1, 2), (0.2 + turned, 1.5 + turned))
    assert found.success
    assert found.area == pytest.approx(exact, rel=1e-6)
    system, tip = arm([1, 0.7])
    with pytest.raises(sr.SarrusError, match="1 degree of freedom"):
        sr.workspace(system, tip["x", "y"], limits={"q1": (-1, 2), "q2": (0.5, 0.5)})
    with pytest.raises(sr.SarrusError, match="is an output"):
        sr.workspace(system, tip["x", "y"], limits={tip["x"][0]: (0.5, 0.5)})
