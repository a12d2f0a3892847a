"""The units of numbers by name, as the parts of a model declare them."""

import pytest

import sarrus as sr
from sarrus.studies.file import unit_of_number

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
    "arm.inertia.xx": "kg m^2",
    "arm.angular_velocity.z": "rad/s",
    "pin.point.x": "m",
    "pin.axis.x": "1",
    "coil.k": "N m/rad",
    "coil.k.2.y": "",  # of a table: not told apart from numbers in formulas
    "motor.motion.1": "",
    "push.force.x": "",
    "gravity.y": "m/s^2",
    "size": "",
    "start.q.arm.r.x": "",
}


@pytest.mark.parametrize("name", UNITS)
def test_units_by_name(name: str) -> None:
    assert unit_of_number(MODEL, name) == UNITS[name]
