"""Derivatives by name: of a number, of a vector's three, of one response of several, of a coordinate over time."""

import numpy as np
import pytest
from tests.system.mechanisms import slider_crank

import sarrus as sr

WRT = ["spring.k", "pin.point"]


@pytest.fixture(scope="module")
def run() -> sr.Trajectory:
    return sr.simulate(slider_crank(), until=0.05, store="steps")


def test_gradients_of_vectors_and_of_one_response(run: sr.Trajectory) -> None:
    both = sr.sensitivity(run, ["slider.x", "slider.velocity.x"], WRT)
    assert np.array_equal(both["pin.point"], both.matrix[:, 1:])
    assert np.array_equal(both["final of slider.velocity.x", "pin.point"], both.matrix[1, 1:])
    assert both["final of slider.x", "spring.k"] == both.matrix[0, 0]
    one = sr.sensitivity(run, "slider.x", WRT)
    assert one["pin.point"] == pytest.approx(both.matrix[0, 1:], rel=1e-12, abs=1e-15)  # in fewer lanes
    with pytest.raises(KeyError, match=r"no response 'slider.x'. Choose from final of slider\.x"):
        both["slider.x", "spring.k"]
    with pytest.raises(KeyError, match=r"no derivative with respect to 'pin'. Choose from spring\.k"):
        sr.sensitivity(run, "slider.x", ["spring.k"])["pin"]


def test_second_derivatives_of_vectors(run: sr.Trajectory) -> None:
    bend = sr.hessian(run, "slider.x", WRT)
    assert np.array_equal(bend["pin.point", "spring.k"], bend.matrix[1:, 0])
    assert np.array_equal(bend["spring.k", "pin.point"], bend.matrix[0, 1:])
    assert np.array_equal(bend["pin.point", "pin.point"], bend.matrix[1:, 1:])
    assert bend["spring.k", "pin.point.y"] == bend.matrix[0, 2]


def test_states_over_time_by_name(run: sr.Trajectory) -> None:
    found = sr.state_derivatives(run, WRT)
    at = run.coordinate_names.index("slider.r.x")
    assert np.array_equal(found["slider.x", "spring.k"], found.q_b[:, at, 0])
    assert found["slider.x", "pin.point"].shape == (len(found.t), 3)
    assert found["slider.x", "spring.k"][-1] == pytest.approx(
        sr.sensitivity(run, "slider.x", WRT)["spring.k"]
    )
    with pytest.raises(KeyError, match=r"has no output 'slidr\.x'"):
        found["slidr.x", "spring.k"]
    with pytest.raises(KeyError, match="An output and a parameter are needed"):
        found["spring.k"]


def test_a_gradient_is_read_as_a_mapping(run: sr.Trajectory) -> None:
    found = sr.sensitivity(run, "slider.x", WRT)
    assert list(found) == list(found.keys()) == list(found.names)
    assert dict(found) == {name: found[name] for name in found.names}
    assert dict(found.items()) == dict(found)
    assert "spring.k" in found
    assert len(found) == 4
    with pytest.raises(
        TypeError, match=r'must be read by names, got .* Use g\["spring\.k"\], .* the array g\.matrix'
    ):
        found[0]  # type: ignore[index]
