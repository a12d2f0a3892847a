"""Branch points and dead centres are found along motions and families of positions, and located."""

import numpy as np
import pytest
from tests.analyses.linkages import parallelogram, parallelogram_points, slider_crank_in_line
from tests.system.mechanisms import slider_crank

import sarrus as sr

CRANK, ROD, FIRST = 1.0, 2.5, 0.7


def planar(poses: list[tuple[np.ndarray, float]]) -> np.ndarray:
    """Coordinates of bodies at given points, turned about z."""
    return np.array([x for r, angle in poses for x in (*r, np.cos(angle / 2), 0, 0, np.sin(angle / 2))])


def parallel(angle: float) -> np.ndarray:
    points = parallelogram_points(angle)
    middle = (points[:-1] + points[1:]) / 2
    return planar([(middle[0], angle - 1), (middle[1], 0.0), (middle[2], angle - 1)])


def crank_and_slider(angle: float) -> np.ndarray:
    def parts(theta: float) -> tuple[np.ndarray, np.ndarray, float]:
        B = CRANK * np.array([np.cos(theta), np.sin(theta), 0])
        C = np.array([B[0] + np.sqrt(ROD**2 - B[1] ** 2), 0, 0])
        return B, C, np.arctan2(C[1] - B[1], C[0] - B[0])

    (B, C, slope), (_, _, first) = parts(angle), parts(FIRST)
    return planar([(B / 2, angle - FIRST), ((B + C) / 2, slope - first), (C, 0.0)])


@pytest.mark.one_in(4)
@pytest.mark.parametrize("count", [41, 40, 21], ids=["on the grid", "off the grid", "coarse"])
@pytest.mark.parametrize("inputs", [(), ("hinge_1",)], ids=["free", "driven"])
def test_flat_parallelogram(count: int, inputs: tuple[str, ...]) -> None:
    found = sr.singularities(parallelogram(), parallel, np.linspace(-1, 4, count), inputs=inputs)
    assert [s.kind for s in found] == ["branch", "branch"]
    assert np.allclose([s.at for s in found], [0, np.pi], atol=1e-9)
    assert all(s.smallest < 1e-9 for s in found)
    assert sr.mobility(parallelogram(), found[0].q).kind == "branching"


@pytest.mark.parametrize("inputs", ["guide", "slider.x"])
def test_dead_centres_of_a_slider(inputs: str) -> None:
    found = sr.singularities(
        slider_crank_in_line(), crank_and_slider, np.linspace(-1, 6, 50), inputs=[inputs]
    )
    assert [s.kind for s in found] == ["dead centre", "dead centre"]
    assert np.allclose([s.at for s in found], [0, np.pi], atol=1e-9)
    assert f"{inputs} stands still" in found[0].message


def test_a_driven_crank_has_no_dead_centre() -> None:
    grid = np.linspace(-1, 6, 50)
    assert sr.singularities(slider_crank_in_line(), crank_and_slider, grid, inputs=["centre"]) == ()
    assert sr.singularities(slider_crank_in_line(), crank_and_slider, grid) == ()


def test_dead_centres_along_a_simulated_motion() -> None:
    system = slider_crank_in_line()
    run = sr.simulate(system, until=1.5, t_eval=np.linspace(0, 1.5, 61), method=sr.ODE(rtol=1e-8, atol=1e-10))
    found = sr.singularities(system, run, inputs=["guide"])
    assert [s.kind for s in found] == ["dead centre", "dead centre"]
    slider = system.coordinates_of("slider")
    assert np.allclose([s.q[slider][0] for s in found], [ROD + CRANK, ROD - CRANK], atol=1e-10)
    before = run.t < found[0].at
    assert np.argmax(run.q[:, slider][:, 0]) in (before.sum() - 1, before.sum())


def test_the_spatial_slider_crank() -> None:
    """Where the slider turns back its velocity vanishes."""
    system = slider_crank()
    run = sr.simulate(system, until=1.2, t_eval=np.linspace(0, 1.2, 61), method=sr.ODE(rtol=1e-8, atol=1e-10))
    found = sr.singularities(system, run, inputs=["slider.x"])
    x_dot = run["slider"].velocity[:, 0]
    turns = run.t[1:][np.diff(np.sign(x_dot)) != 0]
    assert len(found) >= 1
    assert all(np.min(abs(turns - s.at)) < 0.03 for s in found)


def test_inputs_must_be_as_many_as_freedoms() -> None:
    grid = np.linspace(-1, 6, 5)
    with pytest.raises(ValueError, match="need as many inputs"):
        sr.singularities(slider_crank_in_line(), crank_and_slider, grid, inputs=["guide", "centre"])
    with pytest.raises(KeyError, match="has no output 'gide'"):
        sr.singularities(slider_crank_in_line(), crank_and_slider, grid, inputs=["gide"])
    with pytest.raises(ValueError, match="a function of positions needs one"):
        sr.singularities(slider_crank_in_line(), crank_and_slider)
