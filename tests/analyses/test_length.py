"""The size of a system, against the rotation matrix of each body."""

import inspect
import re
import sys
from itertools import pairwise

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.equations.joint_wrenches import SIDES
from sarrus.analyses.equations.length import extent, unit_displacement
from sarrus.elements import Element


def rotation(p: np.ndarray) -> np.ndarray:
    """The rotation matrix, I + 2 (e0 ẽ + ẽ ẽ)."""
    e0, (x, y, z) = p[0], p[1:]
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * (e0 * skew + skew @ skew)


def test_the_extent_is_that_of_all_points() -> None:
    ball = sr.Body("ball", mass=1.0, inertia=[1, 1, 1])
    spring = sr.TSDA("spring", sr.ground.point(0, -3, 0), ball.point(0, 0, 2), k=1.0, length=1.0)
    system = sr.System(sr.Model("model", bodies=[ball], forces=[spring]))
    q = np.array([0.1, 0.2, 0.3, *np.array([0.9, 0.3, -0.2, 0.1]) / np.sqrt(0.95)])
    points = np.array([q[:3], [0.0, -3.0, 0.0]])  # with the end of the spring as the only lever arm
    squares = ((points - points.mean(axis=0)) ** 2).sum() + 2.0**2
    assert np.isclose(unit_displacement(system, q), 2 * np.sqrt(squares / 3), rtol=1e-14)
    disc = sr.RollingDisc(
        "disc", center=ball.point(0, 0, 2), plane=sr.ground.frame((0, 0, 0)), radius=1.0, axis=(0, 1, 0)
    )
    rolling = sr.System(sr.Model("model", bodies=[ball], joints=[disc]))
    points[1] = 0.0  # of the plane; the disc is two elements with a center and a radius each
    squares = ((points - points.mean(axis=0)) ** 2).sum() + 2 * (2.0**2 + 1.0**2)
    assert np.isclose(unit_displacement(rolling, q), 2 * np.sqrt(squares / 6), rtol=1e-14)
    ends = np.array([q[:3], [0.0, -3.0, 0.0], q[:3] + rotation(q[3:]) @ [0.0, 0.0, 2.0]])
    assert np.isclose(extent(system, q), np.ptp(ends, axis=0).max(), rtol=1e-14)


def subclasses(kind: type[Element]) -> list[type[Element]]:
    return [kind, *(below for one in kind.__subclasses__() for below in subclasses(one))]


def test_fields_with_the_names_of_points_have_the_unit_of_a_point() -> None:
    """An orientation called s was taken for a point at the origin."""
    seen = set()
    for kind in subclasses(Element):
        for name in SIDES.keys() & getattr(kind, "fields", {}).keys():
            written = [
                one
                for one in kind.__mro__
                if getattr(sys.modules.get(one.__module__), one.__name__, None) is one
            ]
            own = [inspect.getsource(one) for one in written if one.__module__.startswith("sarrus.")]
            units = re.findall(rf"^    {name}: Vec3  # \[(.*?)\]", "\n".join(own), re.MULTILINE)
            assert {*units} <= {"m"}, (kind, name)
            seen.update([name] if units else [])
    assert seen == SIDES.keys()


def test_a_loop_with_a_spherical_spring_moves_far_from_the_origin_as_near_it() -> None:
    angles = []
    for x in (0.0, 300.0):
        ends = [(x, 0, 0), (x, 0.4, 0.05), (x + 1, 0.8, 0.1), (x + 1.2, 0, 0)]
        rods = [
            sr.Body.rod(f"rod_{n}", *pair, radius=0.02, mass=1.0) for n, pair in enumerate(pairwise(ends))
        ]
        sides = [*pairwise([sr.ground, *rods, sr.ground])]
        joints = [
            sr.Spherical(name, *pair, point=at)
            if name in "BC"
            else sr.Revolute(name, *pair, point=at, axis=(0, 0, 1))
            for name, pair, at in zip("ABCD", sides, ends, strict=True)
        ]
        spring = sr.SphericalSpring("spring", *sides[0], point=ends[0], friction=0.5)
        system = sr.System(sr.Model("loop", rods, joints, [spring], gravity=(0, -9.81, 0)))
        run = sr.simulate(system, until=0.1, method=sr.HHT())
        assert run.success, run.message
        angles.append(run["A.angle"][-1])
    assert angles[1] == pytest.approx(angles[0], abs=1e-6)
