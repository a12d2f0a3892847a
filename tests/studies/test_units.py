"""Units of parameters by name, as the parts of a model declare them, and of derivatives by them."""

import pytest

import sarrus as sr
from sarrus.outputs.units import unit_of_parameter

ARM = sr.Body("arm", mass=1.0, inertia=(1, 1, 1), orientation=sr.AxisAngle((0, 0, 1), 0.1))
MODEL = sr.Model(
    "arm",
    bodies=[ARM],
    joints=[sr.Revolute("pin", sr.ground, ARM, point=(0, 0, 0), axis=(0, 0, 1))],
    forces=[
        sr.RSDA("coil", sr.ground, ARM, point=(0, 0, 0), axis=(0, 0, 1), k=[(-1, 2), (0, 3), (1, 4)]),
        sr.PointForce("push", ARM.point(1, 0, 0), force=(1, 0, 0)),
        sr.TSDA("spring", sr.ground.global_point(1, 2, 3), ARM.point(1, 0, 0), k=1, length=1),
        sr.Bushing(
            "mount",
            frame_i=sr.Frame(sr.ground.point(0, 0, 0)),
            frame_j=sr.Frame(ARM.point(0, 0, 0)),
            stiffness=(1, 1, 1, 1, 1, 1),
        ),
        sr.Torque("curve", "pin", value=[[0, 1], [1, 2]], over="pin.rate"),
        sr.Force("strut", sr.ground.point(3, 0, 0), ARM.point(1, 0, 0), value=[[0, 1], [1, 2]], over="x"),
        sr.Torque("law", "pin", value="3 - 2*v"),
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
    "push.point.z": "m",
    "spring.point_i.x": "m",
    "spring.point_j.y": "m",
    "mount.frame_i.point.x": "m",
    "mount.frame_j.x.y": "1",
    "curve.value.2.y": "N m",
    "strut.value.2.y": "N",
    "law.value.1": "",
    "arm.orientation.angle": "rad",
    "arm.orientation.axis.x": "1",
    "gravity.y": "m/s²",
    "size": "",
    "start.q.arm.r.x": "m",
    "start.v.arm.p.e0": "1/s",
}


@pytest.mark.parametrize("name", UNITS)
def test_units_by_name(name: str) -> None:
    assert unit_of_parameter(MODEL, name) == UNITS[name]


def test_ranges_and_distributions_with_units() -> None:
    assert sr.Range("60 mm", "0.1 m").grid() == pytest.approx([0.06, 0.07, 0.08, 0.09, 0.1])
    assert sr.Distribution("norm", {"loc": "1 kg", "scale": "100 g"}).arguments == {"loc": 1.0, "scale": 0.1}
    distribution = sr.Distribution("norm", {"loc": "1 N", "scale": 0.1})
    for wrong in (sr.Range("60 mm", "0.1 m"), distribution, ["5 mm"], "5 N"):
        with pytest.raises(sr.SarrusError, match=r"arm.mass expects kg, but .* is in"):
            sr.study(MODEL, {"arm.mass": wrong}, {"x": "arm.x"}, analysis=sr.Simulation(until=0.1), workers=1)
    with pytest.raises(sr.SarrusError, match="must rise"):
        sr.Range("1 m", "60 mm")
