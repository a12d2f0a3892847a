"""Random roads have the spectrum of their class, tracks with the coherence of roads, and begin smoothly."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import welch

import sarrus as sr
from sarrus.model.laws.road import BAND, RandomRoad

LENGTH, STEP = 10_000.0, 0.05


@pytest.fixture(scope="module")
def tracks():
    road = RandomRoad("C", length=LENGTH, seed=7)
    x = np.arange(20.0, LENGTH, STEP)
    return road, [np.interp(x, *np.array(track.pairs).T) for track in (road.left, road.right)]


def octaves():
    """Bands within the range of frequencies that a spectrum over 200 m resolves."""
    edges = 0.04 * 2.0 ** np.arange(7)
    return list(pairwise(edges))


@pytest.mark.parametrize("side", [0, 1])
def test_power_of_each_octave(tracks, side):
    """The power within octave bands is that of G = 256e-6 (n / 0.1)^-2, its integral in closed form."""
    n, power = welch(tracks[1][side], 1 / STEP, nperseg=8000, window="hann")
    for low, high in octaves():
        found = power[(n >= low) & (n < high)].sum() * n[1]
        assert found == pytest.approx(256e-6 * 0.01 * (1 / low - 1 / high), rel=0.05)


def test_variance_of_the_whole_band(tracks):
    expected = 256e-6 * 0.01 * (1 / BAND[0] - 1 / BAND[1])
    assert np.var(tracks[1][0]) == pytest.approx(expected, rel=0.02)


def test_coherence_of_octaves(tracks):
    """The covariance of the two tracks within a band, divided by the power, is γ, which falls from 1 to 0."""
    road, (left, right) = tracks
    n = np.fft.rfftfreq(len(left), STEP)
    a, b = np.fft.rfft(left * np.hanning(len(left))), np.fft.rfft(right * np.hanning(len(left)))
    gammas = []
    for low, high in octaves():
        band = (n >= low) & (n < high)
        weight = np.abs(a[band]) ** 2
        gammas.append((a[band] * b[band].conj()).real.sum() / weight.sum())
        assert gammas[-1] == pytest.approx(np.average(road.coherence(n[band]), weights=weight), abs=0.02)
    assert gammas[0] > 0.9
    assert gammas[-1] < 0.15


def test_spline_between_its_points():
    """Between the points the spline follows the cosines: their second derivatives agree with the band's limit."""
    road = RandomRoad("A", length=60.0, seed=1)
    finer = np.linspace(20.0, 40.0, 9001)
    z = np.array([road.left(x) for x in finer])
    curvature = np.diff(z, 2) / (finer[1] - finer[0]) ** 2
    power = 16e-6 * 0.01 * (2 * np.pi) ** 4 * (BAND[1] ** 3 - BAND[0] ** 3) / 3
    assert np.var(curvature) == pytest.approx(power, rel=0.3)


def test_it_begins_flat():
    road = RandomRoad("B", length=50.0, seed=2, start=5.0, blend=8.0)
    x = np.array([-3.0, 0.0, 4.2])
    assert np.abs([road.left(one) for one in x]).max() < 1e-12  # [m]
    assert (
        np.abs([road.left(4.99), road.left(5.0)]).max() < 1e-8
    )  # between the spline's last points before it rises
    assert abs(road.right(20.0)) > 1e-4


@pytest.mark.parametrize("blend", [0.01, 0.3, 50.0])
def test_it_is_level_before_a_short_blend(blend):
    road = RandomRoad("H", length=50.0, blend=blend)
    assert abs(road.left(-100.0)) < 1e-12
    assert abs(road.right(-1.0)) < 1e-12
    assert abs(road.left.pairs[-1][0] - 50.0) < 1e-12


def test_seeds_and_classes():
    same, again = (RandomRoad("D", length=20.0, seed=4).left.pairs for _ in range(2))
    other = RandomRoad("D", length=20.0, seed=5).left.pairs
    by_number = RandomRoad(1024e-6, length=20.0, seed=4).left.pairs
    assert same == again == by_number
    assert same != other


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"roughness": "K"}, 'there is no class "K" of roads. Give one of A, B'),
        ({"roughness": "AB"}, 'there is no class "AB"'),
        ({"roughness": -1e-6}, "roughness must be a positive number"),
        ({"length": 0.0}, "length must be a positive number"),
        ({"length": 5.0}, "blend is 10 m, longer than the road of 5 m. Give a shorter one"),
        ({"width": np.nan}, "width must be a finite number"),
    ],
)
def test_what_is_no_road(options, message):
    with pytest.raises(sr.ModelError, match=message):
        RandomRoad(**({"roughness": "A", "length": 50.0} | options))
