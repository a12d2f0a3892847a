"""Extremes of an output between steps and samples, differentiated exactly."""

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.sensitivity.responses.panels import PARTS


def samples(ends: np.ndarray) -> np.ndarray:
    """Of Lobatto's rule in some panels."""
    return (ends[:-1, None] + np.diff(ends)[:, None] * PARTS).ravel()


def test_a_short_pulse_is_not_lost() -> None:
    """The start of a vibration that decays within a small part of the run."""
    mass = sr.Body("m", mass=1.0, inertia=(1, 1, 1), position=(0.4388, 0, 0))
    slide = sr.Translational("g", sr.ground, mass, point=(0.4388, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("s", sr.ground.point(-5, 0, 0), mass.point(0, 0, 0), k=100.0, c=4.0, length=5.0)
    system = sr.System(sr.Model("m", [mass], [slide], [spring]))
    run = sr.simulate(system, until=5.0, method=sr.Radau(rtol=1e-8, atol=1e-10), store="steps")
    names = ["m.position.x", "s.k"]
    found = sr.sensitivity(run, sr.Maximum("m.x"), names)
    assert found.values == pytest.approx([0.4388], rel=1e-12)
    assert found.matrix[0] == pytest.approx([1.0, 0.0], abs=1e-9)


def test_the_top_of_a_parabola_between_samples() -> None:
    """Exactly, as are its derivatives by height, place and curvature; beside the first and the last sample, too."""
    t = samples(np.linspace(0.0, 1.0, 4))
    for top in (0.33, 0.67, 0.5, 0.04, 0.96, 0.999):
        g = 2.0 - 3.0 * (t - top) ** 2
        assert sr.Maximum("x").value(g, t) == pytest.approx(2.0, abs=1e-14)
        weights = sr.Maximum("x").weights(g, t)
        by = weights @ np.array([np.ones_like(t), 6.0 * (t - top), -((t - top) ** 2)]).T
        assert by == pytest.approx([1.0, 0.0, 0.0], abs=1e-13)


def test_the_extreme_at_an_end_is_the_last_sample_unless_the_output_turns_before_it() -> None:
    t = samples(np.linspace(0.0, 1.0, 4))
    for g in (t**2, (t - 0.07) ** 2, -((t - 1.01) ** 2), -((t - 0.93) ** 2) - 10 * t):
        for side in (slice(None), slice(None, None, -1)):
            assert sr.Maximum("x").value(g[side], t) == g.max()
            assert sr.Minimum("x").value(-g[side], t) == -g.max()


def test_the_top_just_before_an_event() -> None:
    """Where a time occurs twice, and the output jumps."""
    t, top = samples(np.linspace(0.0, 1.0, 3)), 0.48
    g = np.where(np.arange(8) < 4, 2.0 - 3.0 * (t - top) ** 2, -1.0)
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
    run = sr.simulate(system, until=top + behind, method=sr.Radau(rtol=1e-4), store="steps")
    found = sr.sensitivity(run, sr.Maximum("m.x"), ["m.velocity.x", "s.k"])
    highest = np.exp(-2 * top) * np.sin(w * top) / w
    by_k = 5 * np.exp(-2 * top) * (w * top * np.cos(w * top) - np.sin(w * top)) / (2 * w**3)
    assert found.matrix[0] == pytest.approx([highest, by_k], rel=3e-3)


@pytest.mark.parametrize("method", [sr.HHT(step=0.07), sr.HHT(step=0.3), sr.Radau()], ids=repr)
def test_the_top_of_a_flight_between_steps(method: sr.HHT | sr.Radau) -> None:
    """z₀ + v²/2g, which no step meets; the highest step is 2 % lower where steps are 0.3 s long."""
    ball = sr.Body("ball", mass=1.0, inertia=(1, 1, 1), position=(0, 0, 1), velocity=(0, 0, 5))
    system = sr.System(sr.Model("ball", [ball], gravity=(0, 0, -9.81)))
    run = sr.simulate(system, until=1.2, method=method, store="steps")
    assert abs(run.steps.t - 5 / 9.81).min() > 0.01
    names = ["ball.position.z", "ball.velocity.z", "gravity.z"]
    found = sr.sensitivity(run, sr.Maximum("ball.z"), names)
    assert found.values == pytest.approx([1 + 25 / (2 * 9.81)], rel=1e-12)
    assert found.matrix[0] == pytest.approx([1.0, 5 / 9.81, 25 / (2 * 9.81**2)], rel=1e-10)


def test_the_former_smooth_maximum_is_named() -> None:
    with pytest.raises(AttributeError, match=r"sarrus\.Peak was withdrawn\. Use sr\.Maximum"):
        sr.Peak("ball.z")
