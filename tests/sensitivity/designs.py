"""Mechanisms whose dimensions follow from a few numbers by a Python function."""

from functools import cache

import numpy as np

import sarrus as sr
from sarrus.model.geometry import rotation

SPATIAL = {"rod_length": 5.0, "crank_radius": 2.0, "O_y": 1.0, "O_z": 1.0, "theta0": 0.5}


def spatial(d):
    """The shipped slider-crank: crank about x through O, rod from its pin to the slider on the x axis."""
    O = np.array([0.0 * d["O_y"], d["O_y"], d["O_z"]], dtype=object)
    arm = np.array([0.0, -d["crank_radius"] * np.sin(d["theta0"]), d["crank_radius"] * np.cos(d["theta0"])])
    pin = O + arm
    x = np.sqrt(d["rod_length"] ** 2 - pin[1] ** 2 - pin[2] ** 2)
    slider = np.array([x, 0.0, 0.0])
    along = (slider - pin) / d["rod_length"]
    across = np.cross(along, np.array([0.0, 0.0, 1.0]))
    across = across / np.sqrt(across @ across)
    axes = np.column_stack([along, across, np.cross(along, across)])
    return {
        "crank.position": O + arm / 2,
        "crank.orientation.angle": d["theta0"],
        "rod.position": (pin + slider) / 2,
        "rod.orientation": -1 * rotation.parameters(axes),  # the sign that the file has
        "slider.position": slider,
        "pin.point": O,
        "ball.point": pin,
        "cross.point": slider,
        "cross.axis_i": across,
        "guide.point": slider,
    }


SUNDIALS = {"a": 0.5, "J1": 1.0, "m2": 1.0, "J2": 2.0, "k": 1.0, "c": 1.0, "l0": 1.0, "F": 1.0}
LIGHT = 1e-9  # [kg] masses that the published model does not have


def sundials(d):
    """Where the numbers of `sundials_crank` come from: crank angle π/2 at the start, rod of length 1."""
    a = d["a"]
    slider = np.sqrt(1.0 - a * a)
    turn = np.arctan2(-a, slider)
    return {
        "crank.inertia.zz": d["J1"],
        "slider.mass": d["m2"],
        "rod.inertia.zz": d["J2"],
        "spring.k": d["k"],
        "spring.c": d["c"],
        "spring.length": d["l0"],
        "push.force.x": d["F"],
        "pull.force.x": d["F"],
        "release.force.x": -d["F"],
        "spring.point_i.x": a / 2,
        "hinge.point": [0.0, a, 0.0],
        "end.point": [slider, 0.0, 0.0],
        "guide.point": [slider, 0.0, 0.0],
        "rod.position": [slider / 2, a / 2, 0.0],
        "rod.orientation.angle": turn,
        "slider.position": [slider, 0.0, 0.0],
    }


@cache
def sundials_crank() -> sr.System:
    """The planar slider-crank of the SUNDIALS example idasSlCrank_FSA_dns, with masses of 1e-9 kg where it has none."""
    a, x = 0.5, np.sqrt(0.75)
    light = (3.0, 3.0)
    up = sr.AxisAngle((0, 0, 1), np.pi / 2)
    crank = sr.Body("crank", mass=LIGHT, inertia=(*light, 1.0), orientation=up)
    rod = sr.Body(
        "rod",
        mass=LIGHT,
        inertia=(*light, 2.0),
        position=(x / 2, a / 2, 0),
        orientation=sr.AxisAngle((0, 0, 1), np.arctan2(-a, x)),
    )
    slider = sr.Body("slider", mass=1.0, inertia=(1, 1, 1), position=(x, 0, 0))
    axis = (0, 0, 1)
    joints = [
        sr.Revolute("bearing", sr.ground, crank, point=(0, 0, 0), axis=axis),
        sr.Revolute("hinge", crank, rod, point=(0, a, 0), axis=axis),
        sr.Cylindrical("end", rod, slider, point=(x, 0, 0), axis=axis),
        sr.Translational("guide", sr.ground, slider, point=(x, 0, 0), axis=(1, 0, 0)),
    ]
    spring = sr.TSDA("spring", crank.point(a / 2, 0, 0), rod.point(0, 0, 0), k=1.0, c=1.0, length=1.0)
    forces = [
        spring,
        sr.PointForce("push", slider.point(0, 0, 0), force=(1.0, 0, 0)),
        sr.PointForce("pull", rod.point(0.5, 0, 0), force=(1.0, 0, 0)),
        sr.PointForce("release", rod.point(-0.5, 0, 0), force=(-1.0, 0, 0)),
    ]
    return sr.System(sr.Model("slider-crank", bodies=[crank, rod, slider], joints=joints, forces=forces))
