"""Angular velocities in global and in body axes have names of their own, which agree between outputs and runs."""

import numpy as np
import pytest

import sarrus as sr


def spinning() -> sr.Trajectory:
    """A body at an angle to the global axes, without forces."""
    body = sr.Body(
        "top",
        mass=1.0,
        inertia=(1, 2, 3),
        orientation=sr.AxisAngle((1, 2, 2), 0.9),
        angular_velocity=(1, 2, 3),
    )
    return sr.simulate(
        sr.System(sr.Model("free", bodies=[body])),
        until=0.2,
        t_eval=np.linspace(0, 0.2, 5),
        method=sr.Radau(),
    )


def test_names_state_the_axes() -> None:
    run = spinning()
    of_run = run["top"]
    assert of_run.angular_velocity_global[0] == pytest.approx([1, 2, 3])
    for n, axis in enumerate("xyz"):
        assert run[f"top.angular_velocity.{axis}"] == pytest.approx(
            of_run.angular_velocity_global[:, n], rel=1e-12
        )
        assert run[f"top.angular_velocity_body.{axis}"] == pytest.approx(
            of_run.angular_velocity_body[:, n], rel=1e-12
        )
    w, inertia = of_run.angular_velocity_body, np.array([1, 2, 3])
    energy = 0.5 * np.sum(inertia * w**2, axis=1)
    assert energy == pytest.approx(energy[0], rel=1e-5)  # the inertia is that of body axes
    assert abs(0.5 * np.sum(inertia * of_run.angular_velocity_global**2, axis=1) - energy).min() > 0.1


def test_a_run_is_indexed_by_bodies_and_outputs() -> None:
    run = spinning()
    assert np.array_equal(run["top.x"], run.output("top.x").values)
    assert np.array_equal(run["t"], run.t)
    with pytest.raises(KeyError, match='no body "tip"'):
        run["tip"]
    with pytest.raises(KeyError, match=r"no output 'top\.w'"):
        run["top.w"]


def test_printed_results_are_short() -> None:
    run = spinning()
    known = "position, euler, velocity, angular_velocity_global, angular_velocity_body, acceleration"
    known += ", angular_acceleration_global, angular_acceleration_body"
    assert str(run["top"]) == f"BodyMotion('top': {known})"
    assert str(sr.assemble(run.system)).splitlines()[0].startswith("assembled in")
    stored = sr.simulate(run.system, until=0.1, store="steps")
    found = sr.state_derivatives(stored, ["top.mass"])
    assert str(found).startswith("derivatives of coordinates and outputs with respect to top.mass at ")
    assert str(found).endswith("from 0 to 0.1 s")
