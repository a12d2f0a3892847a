"""Responses as functions of an output at some times: their weights, and their derivatives by the times."""

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.sensitivity.responses.panels import Layout
from sarrus.analyses.sensitivity.sampling.sampling import lagrange

# Two panels, one before an event at 0.3 and one behind it
T = np.array([0.0, 0.1, 0.25, 0.3, 0.3, 0.45, 0.55, 0.7])
G = np.array([0.3, -0.2, 0.9, 1.1, 0.7, 1.0, 1.3, -0.4])
KINDS = {
    "integral": (sr.Integral("x"), G),
    "maximum": (sr.Maximum("x"), G),
    "minimum": (sr.Minimum("x"), np.array([0.3, -0.2, 0.9, 1.1, 0.7, 1.0, 1.3, 0.4])),
    "maximum at the end": (sr.Maximum("x"), np.sort(G)),
    "maximum before an event": (sr.Maximum("x"), np.array([0.3, -0.2, 0.9, 2.1, 0.7, 1.0, 1.3, -0.4])),
    "maximum after an event": (sr.Maximum("x"), np.array([0.3, -0.2, 0.9, 1.1, 2.7, 1.0, 1.3, -0.4])),
    "misfit": (sr.Misfit("x", at=T, data=0.1 * T, sigma=0.3), G),
}


def slopes(function: object, at: np.ndarray) -> np.ndarray:
    """Richardson's extrapolation of central differences."""

    def coarse(e: float) -> np.ndarray:
        return np.array([(function(at + e * d) - function(at - e * d)) / (2 * e) for d in np.eye(len(at))])

    return (4 * coarse(5e-4) - coarse(1e-3)) / 3


@pytest.mark.parametrize("kind", KINDS)
def test_weights_are_the_derivatives_by_the_output(kind: str) -> None:
    response, g = KINDS[kind]
    assert response.weights(g, T) == pytest.approx(slopes(lambda x: response.value(x, T), g), abs=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_derivatives_by_the_times(kind: str) -> None:
    """Those of the times at an event move together here, as they do in a run."""
    response, g = KINDS[kind]
    found = response.by_times(g, T)
    wanted = slopes(lambda t: response.value(g, t[[0, 1, 2, 3, 3, 4, 5, 6]]), T[[0, 1, 2, 3, 5, 6, 7]])
    assert np.array([*found[:3], found[3] + found[4], *found[5:]]) == pytest.approx(wanted, abs=1e-7)


@pytest.mark.parametrize("kind", KINDS)
def test_the_change_of_derivatives(kind: str) -> None:
    """Of those by the output and by the times, where both change; both times at an event change alike."""
    response, g = KINDS[kind]
    g_dot, t_dot = np.cos(np.arange(len(g))), 0.3 * np.sin(2 * T)
    e = 1e-5
    for name in ("weights", "by_times"):
        ends = [getattr(response, name)(g + s * e * g_dot, T + s * e * t_dot) for s in (1, -1)]
        if kind == "misfit":  # whose times are given
            ends = [getattr(response, name)(g + s * e * g_dot, T) for s in (1, -1)]
        found = getattr(response, f"{name}_along")(g, T, g_dot, t_dot)
        assert found == pytest.approx((ends[0] - ends[1]) / (2 * e), abs=1e-6 * (1 + abs(found).max())), name


def test_polynomials_through_nodes() -> None:
    """They repeat a cubic: its value and slope at zero."""
    t = np.array([[-0.3, 0.1, 0.4, 1.1], [0.0, 0.2, 0.5, 0.6]])
    values, slopes, _ = lagrange(t)
    cubic = 2 - 3 * t + 0.5 * t**2 + 4 * t**3
    assert np.sum(values * cubic, axis=1) == pytest.approx([2, 2], rel=1e-13)
    assert np.sum(slopes * cubic, axis=1) == pytest.approx([-3, -3], rel=1e-13)


def test_a_corner_at_a_kink() -> None:
    """Of two polynomials that intersect: derivatives of its value, and their changes, by Richardson's differences."""
    time, t = 0.4, np.concatenate([np.linspace(0.1, 0.4, 5), np.linspace(0.4, 0.7, 5)])
    away, rng = t - time, np.random.default_rng(1)
    g = np.where(np.arange(10) < 5, 1 + 2 * away + away**2, 1 - 3 * away + 2 * away**3)
    near, dots = Layout(np.array([4]), 5), rng.normal(size=(2, 10))

    def value(x: np.ndarray) -> float:
        """Where both polynomials are equal, by Newton's method."""
        sides = [np.polynomial.Polynomial.fit(x[1, s], x[0, s], 4) for s in (slice(5), slice(5, None))]
        at = time
        for _ in range(5):
            at -= (sides[0](at) - sides[1](at)) / (sides[0].deriv()(at) - sides[1].deriv()(at))
        return float(sides[0](at))

    def slopes(e: float) -> np.ndarray:
        at = np.array([g, t]) + e * dots
        steps = 1e-4 * np.eye(20).reshape(20, 2, 10)
        ends = [[value(at + s * d) for s in (2, 1, -1, -2)] for d in steps]
        return np.array([(8 * (b - c) - (a - d)) / 12e-4 for a, b, c, d in ends]).reshape(2, 10)

    response = sr.Maximum("x", layout=near)
    assert response.value(g, t) == pytest.approx(1.0, abs=1e-13)
    found = np.array([response.weights(g, t), response.by_times(g, t)])
    assert found == pytest.approx(slopes(0.0), abs=1e-7)
    turned = np.array([response.weights_along(g, t, *dots), response.by_times_along(g, t, *dots)])
    e = 1e-4
    assert turned == pytest.approx((slopes(e) - slopes(-e)) / (2 * e), abs=2e-4 * abs(turned).max())
