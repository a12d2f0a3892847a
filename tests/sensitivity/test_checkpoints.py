"""Gradients by checkpoints are those of runs whose steps are all kept, to the last bits."""

import numpy as np
import pytest
from tests.system.mechanisms import slider_crank

import sarrus as sr

SETTINGS = {"rtol": 1e-5, "atol": 1e-7}
RESPONSES = [
    sr.Final("slider.x"),
    sr.Integral("energy.kinetic"),
    sr.At("spring.length", time=0.33),
    sr.Peak("slider.velocity.x"),
    sr.Misfit("slider.x", at=(0.1, 0.2, 0.75), data=(1.0, 1.1, 1.2)),
    sr.Integral(lambda o: o.parameter("spring.k") * o("slider.x"), name="own"),
]


@pytest.mark.parametrize("every", [7, 400])
def test_the_gradient_is_that_of_all_steps(every: int) -> None:
    system = slider_crank()
    run = sr.simulate(system, until=0.8, keep_steps=True, **SETTINGS)
    wanted = sr.sensitivity(run, RESPONSES)
    found = sr.sensitivity_by_checkpoints(system, RESPONSES, until=0.8, every=every, **SETTINGS)
    assert len(run.steps) > 40
    assert found.responses == wanted.responses
    assert np.allclose(found.values, wanted.values, rtol=1e-13, atol=0)
    for row, whole in zip(found.matrix, wanted.matrix, strict=True):
        assert abs(row - whole).max() < 1e-13 * abs(whole).max()


def test_angles_with_turns_are_refused() -> None:
    with pytest.raises(ValueError, match="count turns"):
        sr.sensitivity_by_checkpoints(slider_crank(), "pin.angle", until=0.1)
