"""Units of parameters by name, as the parts of a model declare them, and of derivatives by them."""

import pytest

import sarrus as sr
from sarrus.outputs.units import unit_of_parameter

ARM = sr.Body("arm", mass=1.0, inertia=(1, 1, 1))
MODEL = sr.Model(
    "arm",
    bodies=[ARM],
    joints=[sr.Revolute("pin", sr.ground, ARM, point=(0, 0, 0), axis=(0, 0, 1))],
    forces=[
        sr.RSDA("coil", sr.ground, ARM, point=(0, 0, 0), axis=(0, 0, 1), k=[(-1, 2), (0, 3), (1, 4)]),
        sr.PointForce("push", ARM.point(1, 0, 0), force=(1, 0, 0)),
    ],
    drivers=[sr.AngleDriver("motor", "pin", "2*t")],
    gravity=(0, -9.81, 0),
)
UNITS = {
    "arm.mass": "kg",
    "arm.inertia.xx": "kg m²",
    "arm.angular_velocity.z": "rad/s",
    "pin.point.x": "m",
    "pin.axis.x": "1",
    "coil.k": "N m/rad",
    "coil.k.2.y": "N m/rad",
    "coil.k.2.x": "rad",
    "motor.motion.1": "",  # a constant of a formula
    "push.force.x": "N",
    "gravity.y": "m/s²",
    "size": "",
    "start.q.arm.r.x": "m",
    "start.v.arm.p.e0": "1/s",
}


@pytest.mark.parametrize("name", UNITS)
def test_units_by_name(name: str) -> None:
    assert unit_of_parameter(MODEL, name) == UNITS[name]
