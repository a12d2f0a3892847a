"""A force by formula takes the name of its joint in second place, as a torque does."""

import numpy as np

import sarrus as sr


def model(*place: str, **by_name: str) -> sr.Model:
    ram = sr.Body("ram", mass=2, inertia=(1, 1, 1))
    slide = sr.Translational("slide", sr.ground, ram, point=(0, 0, 0), axis=(1, 0, 0))
    return sr.Model("jack", [ram], [slide], [sr.Force("jack", *place, value="6 - 2*v", **by_name)])


def test_force_on_a_joint_in_second_place() -> None:
    """m a = 6 - 2 v."""
    run = sr.simulate(sr.System(model("slide")), until=1.0)
    assert abs(run["ram"].velocity[-1, 0] - 3 * (1 - np.exp(-1.0))) < 1e-8
    (force,), (named,) = (one.forces for one in (model("slide"), model(joint="slide")))
    assert (force.joint, force.point_i) == (named.joint, named.point_i) == ("slide", None)
