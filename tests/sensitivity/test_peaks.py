"""The peak of an output by default: near to the maximum whatever the scale, and differentiated exactly."""

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.sensitivity.responses.peaks import SHARPNESS

T = np.linspace(0.0, 5.0, 400)
SHAPES = {
    "one bump": np.exp(-((T - 1.0) ** 2) / 0.02),
    "waves": np.sin(7 * T),
    "falling waves": np.exp(-0.1 * T) * np.sin(7 * T),
    "a rise": T,
    "a fall": -T,
    "two equal ends": (T - 2.5) ** 2,
    "constant": np.ones_like(T),
}


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("offset", [0.0, 1.0, -30.0])
@pytest.mark.parametrize("shape", SHAPES)
def test_it_is_the_maximum_to_a_thousandth_of_the_range(shape: str, offset: float, scale: float) -> None:
    g = scale * (SHAPES[shape] + offset)
    found, most = sr.Peak("x").value(g, T), sr.Maximum("x").value(g, T)
    assert abs(found - most) <= max(0.3 / SHARPNESS * np.ptp(g), 1e-15 * abs(most))


def test_one_peak_above_the_others_is_the_maximum() -> None:
    """A peak is the vertex of a parabola, the maximum that of the polynomial through more samples."""
    g = SHAPES["falling waves"]
    near = slice(np.argmax(g) - 1, np.argmax(g) + 2)
    parabola = np.polynomial.Polynomial.fit(T[near], g[near], 2)
    top = parabola(float(parabola.deriv().roots()[0]))
    assert sr.Peak("x").value(g, T) == pytest.approx(top, rel=1e-12)
    assert sr.Peak("x").value(g, T) == pytest.approx(sr.Maximum("x").value(g, T), rel=2e-6)
    assert np.flatnonzero(abs(sr.Peak("x").weights(g, T)) > 1e-9).tolist() == list(
        range(near.start, near.stop)
    )


def test_its_derivative_passes_from_one_peak_to_the_other() -> None:
    """Where two are equally high it is the mean of theirs, and changes gradually from one to the other."""
    first, second = np.exp(-((T - 1) ** 2) / 0.05), np.exp(-((T - 4) ** 2) / 0.05)
    shares = []
    for more in (-1e-2, -1e-3, 0.0, 1e-3, 1e-2):
        weights = sr.Peak("x").weights(first + (1 + more) * second, T)
        shares.append(weights[T > 2.5].sum())
    assert shares[2] == pytest.approx(0.5, abs=1e-6)
    assert np.all(np.diff(shares) > 0) or shares[0] == pytest.approx(0.0, abs=1e-3)
    assert shares[-1] == pytest.approx(1.0, abs=1e-3)


def test_a_short_pulse_is_not_lost() -> None:
    """With a sharpness of 50 the mean over the time took 5 % off."""
    mass = sr.Body("m", mass=1.0, inertia=(1, 1, 1), position=(0.4388, 0, 0))
    slide = sr.Translational("g", sr.ground, mass, point=(0.4388, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("s", sr.ground.point(-5, 0, 0), mass.point(0, 0, 0), k=100.0, c=4.0, length=5.0)
    system = sr.System(sr.Model("m", [mass], [slide], [spring]))
    run = sr.simulate(system, until=5.0, method=sr.Radau(), rtol=1e-8, atol=1e-10, store_steps=True)
    names = ["m.position.x", "s.k"]
    found = sr.sensitivity(run, [sr.Peak("m.x"), sr.Peak("m.x", sharpness=50.0), sr.Maximum("m.x")], names)
    assert found.values[0] == pytest.approx(0.4388, abs=1e-3 * 0.7)
    assert found.values[1] < 0.425
    assert found.matrix[0] == pytest.approx(found.matrix[2], abs=1e-9)


def test_the_top_of_a_parabola_between_samples() -> None:
    """Exactly, as are its derivatives by height, place and curvature; beside the first and the last sample, too."""
    t = np.linspace(0.0, 1.0, 11)
    for top in (0.33, 0.67, 0.5, 0.04, 0.96, 0.999):
        g = 2.0 - 3.0 * (t - top) ** 2
        for one in (sr.Peak("x"), sr.Maximum("x")):
            assert one.value(g, t) == pytest.approx(2.0, abs=1e-14)
            by = one.weights(g, t) @ np.array([np.ones_like(t), 6.0 * (t - top), -((t - top) ** 2)]).T
            assert by == pytest.approx([1.0, 0.0, 0.0], abs=1e-13)


def test_the_extreme_at_an_end_is_the_last_sample_unless_the_output_turns_before_it() -> None:
    t = np.linspace(0.0, 1.0, 11)
    for g in (t**2, (t - 0.07) ** 2, -((t - 1.01) ** 2), -((t - 0.93) ** 2) - 10 * t):
        for side in (slice(None), slice(None, None, -1)):
            assert sr.Maximum("x").value(g[side], t) == g.max()
            assert sr.Minimum("x").value(-g[side], t) == -g.max()


def test_the_top_just_before_an_event() -> None:
    """Where a time occurs twice, and the output jumps."""
    t, top = np.concatenate([np.linspace(0.0, 0.5, 6), np.linspace(0.5, 1.0, 6)]), 0.48
    g = np.where(np.arange(12) < 6, 2.0 - 3.0 * (t - top) ** 2, -1.0)
    assert sr.Maximum("x").value(g, t) == pytest.approx(2.0, abs=1e-14)
    assert sr.Minimum("x").value(-g, t) == pytest.approx(-2.0, abs=1e-14)


@pytest.mark.parametrize("behind", [0.0005, 0.0035, 0.01])
def test_the_top_within_the_last_long_step(behind: float) -> None:
    """Of a damped mass: the derivative was off by 6 %, as the last sample was taken."""
    mass = sr.Body("m", mass=1.0, inertia=(1, 1, 1), velocity=(5, 0, 0))
    slide = sr.Translational("g", sr.ground, mass, point=(0, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("s", sr.ground.point(-5, 0, 0), mass.point(0, 0, 0), k=100.0, c=4.0, length=5.0)
    w = np.sqrt(96.0)
    top = np.arctan2(w, 2.0) / w
    system = sr.System(sr.Model("m", [mass], [slide], [spring]))
    run = sr.simulate(system, until=top + behind, rtol=1e-4, store_steps=True)
    found = sr.sensitivity(run, sr.Peak("m.x"), ["m.velocity.x", "s.k"])
    highest = np.exp(-2 * top) * np.sin(w * top) / w
    by_k = 5 * np.exp(-2 * top) * (w * top * np.cos(w * top) - np.sin(w * top)) / (2 * w**3)
    assert found.matrix[0] == pytest.approx([highest, by_k], rel=3e-3)


@pytest.mark.parametrize("method", [sr.HHT(step=0.07), sr.HHT(step=0.3), sr.Radau()], ids=repr)
def test_the_top_of_a_flight_between_steps(method: sr.HHT | sr.Radau) -> None:
    """z₀ + v²/2g, which no step meets; the highest step is 2 % lower where steps are 0.3 s long."""
    ball = sr.Body("ball", mass=1.0, inertia=(1, 1, 1), position=(0, 0, 1), velocity=(0, 0, 5))
    system = sr.System(sr.Model("ball", [ball], gravity=(0, 0, -9.81)))
    run = sr.simulate(system, until=1.2, method=method, store_steps=True)
    assert abs(run.steps.t - 5 / 9.81).min() > 0.01
    names = ["ball.position.z", "ball.velocity.z", "gravity.z"]
    found = sr.sensitivity(run, [sr.Peak("ball.z"), sr.Maximum("ball.z")], names)
    for values, slopes in zip(found.values, found.matrix, strict=True):
        assert values == pytest.approx(1 + 25 / (2 * 9.81), rel=1e-12)
        assert slopes == pytest.approx([1.0, 5 / 9.81, 25 / (2 * 9.81**2)], rel=1e-10)
