"""Planar mechanisms with workspaces that are known in closed form, made of spatial joints."""

from math import atan2, cos, sin

import numpy as np

import sarrus as sr

DEGREE = np.pi / 180
Limits = dict[object, tuple[float | None, float | None]]
Case = tuple[sr.System, tuple[object, ...], Limits]


def arm(lengths: list[float]) -> tuple[sr.System, sr.Point]:
    """Links on hinges along x, and the tip."""
    bodies: list[sr.Body] = []
    joints = []
    x = 0.0
    for n, length in enumerate(lengths, start=1):
        body = sr.Body(f"link_{n}", mass=1, inertia=(1, 1, 1), position=(x, 0, 0))
        before = bodies[-1] if bodies else sr.ground
        joints.append(sr.Revolute(f"q{n}", before, body, point=(x, 0, 0), axis=(0, 0, 1)))
        bodies.append(body)
        x += length
    return sr.System(sr.Model("arm", bodies=bodies, joints=joints)), bodies[-1].point(lengths[-1], 0, 0)


def arm_2r() -> Case:
    system, tip = arm([1, 0.7])
    return system, tip["x", "y"], {"q1": (-60 * DEGREE, 120 * DEGREE), "q2": (20 * DEGREE, 150 * DEGREE)}


def arm_2r_both_elbows() -> Case:
    system, tip = arm([1, 0.7])
    return system, tip["x", "y"], {"q1": (-90 * DEGREE, 90 * DEGREE), "q2": (-120 * DEGREE, 120 * DEGREE)}


def arm_3r() -> Case:
    """The arm of Haug et al. 1996."""
    system, tip = arm([4, 2, 1])
    return system, tip["x", "y"], {f"q{n}": (-60 * DEGREE, 60 * DEGREE) for n in (1, 2, 3)}


def platform(base: list[tuple[float, float]], corners: list[tuple[float, float]]) -> Case:
    """A platform in the plane, its legs as lengths without bodies; limits are to be filled in."""
    body = sr.Body("platform", mass=1, inertia=(1, 1, 1), position=(0.3, 1.2, 0))
    plane = sr.Planar("plane", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
    legs = [
        sr.Length(sr.ground.point(*foot, 0), body.point(*corner, 0), f"leg {n}")
        for n, (foot, corner) in enumerate(zip(base, corners, strict=True), start=1)
    ]
    system = sr.System(sr.Model("3-RPR", bodies=[body], joints=[plane]))
    return system, body.point(0, 0, 0)["x", "y"], dict.fromkeys(legs, (None, None))


def platform_haug() -> Case:
    """The planar Stewart platform of Haug et al. 1996: two legs meet in one corner."""
    system, output, legs = platform([(-1, 0), (1, 0), (2, 0)], [(-1, 0), (-1, 0), (1, 0)])
    return system, output, dict(zip(legs, [(2**0.5, 2), (2**0.5, 2), (1, 3)], strict=True))


def platform_equilateral() -> Case:
    r = 3**-0.5
    base, corners = [(0, 0), (3, 0), (1.5, 1.5 * 3**0.5)], [(-0.5, -r / 2), (0.5, -r / 2), (0, r)]
    system, output, legs = platform(base, corners)
    return system, output, dict.fromkeys(legs, (0.8, 2.2))


def five_bar(balls: bool = False) -> Case:
    """Two cranks of 1.2 m at (-1, 0) and (1, 0), two rods of 1.5 m: five hinges, three redundant equations.

    With ball joints at both ends of the first rod, no equation is redundant, but the rod can spin.
    """
    A1, A2, P = np.array([-1.0, 0.0]), np.array([1.0, 0.0]), np.array([0.1, 1.9])
    B1, B2 = _corner(A1, 1.2, P, 1.5), _corner(P, 1.5, A2, 1.2)
    cranks = [_bar("crank_1", A1, B1), _bar("crank_2", A2, B2)]
    rods = [_bar("rod_1", B1, P), _bar("rod_2", B2, P)]
    at_ends = _ball if balls else _hinge
    joints = [
        _hinge("a1", sr.ground, cranks[0], A1),
        _hinge("a2", sr.ground, cranks[1], A2),
        at_ends("b1", cranks[0], rods[0], B1),
        _hinge("b2", cranks[1], rods[1], B2),
        at_ends("p", rods[0], rods[1], P),
    ]
    system = sr.System(sr.Model("five-bar", bodies=[*cranks, *rods], joints=joints))
    return system, rods[0].point(1.5, 0, 0)["x", "y"], {}


def _bar(name: str, start: np.ndarray, end: np.ndarray) -> sr.Body:
    half = 0.5 * atan2(end[1] - start[1], end[0] - start[0])
    pose = {"position": (*start, 0), "orientation": (cos(half), 0, 0, sin(half))}
    return sr.Body(name, mass=1, inertia=(1, 1, 1), **pose)


def _hinge(name: str, i: sr.Body, j: sr.Body, at: np.ndarray) -> sr.Revolute:
    return sr.Revolute(name, i, j, point=(*at, 0), axis=(0, 0, 1))


def _ball(name: str, i: sr.Body, j: sr.Body, at: np.ndarray) -> sr.Spherical:
    return sr.Spherical(name, i, j, point=(*at, 0))


def _corner(a: np.ndarray, r_a: float, b: np.ndarray, r_b: float) -> np.ndarray:
    """The left one of the two points at given distances from two others."""
    d = b - a
    away = float(np.linalg.norm(d))
    along = (away**2 + r_a**2 - r_b**2) / (2 * away)
    across = (r_a**2 - along**2) ** 0.5
    return a + along * d / away + across * np.array([-d[1], d[0]]) / away


def orthogonal_arm() -> tuple[sr.System, sr.Point]:
    """Three hinges in space, axes z, y and z, that can pass from one elbow to the other without a singularity."""
    places, axes = [(0, 0, 0), (1, 0, 0), (3, 1, 0)], [(0, 0, 1), (0, 1, 0), (0, 0, 1)]
    bodies = [
        sr.Body(f"link_{n}", mass=1, inertia=(1, 1, 1), position=place) for n, place in enumerate(places, 1)
    ]
    chain = [sr.ground, *bodies]
    joints = [
        sr.Revolute(f"q{n + 1}", chain[n], chain[n + 1], point=places[n], axis=axes[n]) for n in range(3)
    ]
    return sr.System(sr.Model("orthogonal 3R", bodies=bodies, joints=joints)), bodies[-1].point(1.5, 0, 0)


def delta() -> tuple[sr.System, sr.Point]:
    """Three arms of 0.3 m on a circle of 0.1 m, rods of 0.6 m as distances, a tool that does not turn."""
    x, y = (sr.Body(name, mass=1, inertia=(1, 1, 1)) for name in "xy")
    tool = sr.Body("tool", mass=1, inertia=(1, 1, 1), position=(0, 0, -0.45))
    joints = [
        sr.Translational("slide_x", sr.ground, x, point=(0, 0, 0), axis=(1, 0, 0)),
        sr.Translational("slide_y", x, y, point=(0, 0, 0), axis=(0, 1, 0)),
        sr.Translational("slide_z", y, tool, point=(0, 0, 0), axis=(0, 0, 1)),
    ]
    arms = []
    for n in range(3):
        c, s = cos(2 * np.pi * n / 3), sin(2 * np.pi * n / 3)
        turn = (cos(np.pi * n / 3), 0, 0, sin(np.pi * n / 3))
        arm = sr.Body(f"arm_{n}", mass=1, inertia=(1, 1, 1), position=(0.1 * c, 0.1 * s, 0), orientation=turn)
        joints.append(sr.Revolute(f"q{n}", sr.ground, arm, point=(0.1 * c, 0.1 * s, 0), axis=(-s, c, 0)))
        joints.append(sr.Distance(f"rod_{n}", arm.point(0.3, 0, 0), tool.point(0, 0, 0), length=0.6))
        arms.append(arm)
    return sr.System(sr.Model("delta", bodies=[x, y, tool, *arms], joints=joints)), tool.point(0, 0, 0)


def spatial_arm(
    places: list[tuple[float, ...]], axes: list[tuple[float, ...]], tip: tuple[float, ...]
) -> Case:
    """Hinges in space at given places with given axes, and the tip's place."""
    bodies = [sr.Body(f"link_{n}", mass=1, inertia=(1, 1, 1), position=at) for n, at in enumerate(places, 1)]
    chain = [sr.ground, *bodies]
    joints = [
        sr.Revolute(f"q{n + 1}", chain[n], chain[n + 1], point=places[n], axis=axes[n])
        for n in range(len(places))
    ]
    own = np.subtract(tip, places[-1])
    system = sr.System(sr.Model("spatial arm", bodies=bodies, joints=joints))
    return system, bodies[-1].point(*own)["x", "y", "z"], {}


def elbow_arm() -> Case:
    """Yaw, pitch and elbow with limits: links of 0.45 and 0.40 m, the shoulder 0.1 m beside the axis, 0.5 m high."""
    system, tip, _ = spatial_arm(
        [(0, 0, 0), (0.1, 0, 0.5), (0.55, 0, 0.5)], [(0, 0, 1), (0, -1, 0), (0, -1, 0)], (0.95, 0, 0.5)
    )
    limits = {"q1": (-160, 160), "q2": (20, 90), "q3": (-120, -10)}
    return system, tip, {name: (low * DEGREE, high * DEGREE) for name, (low, high) in limits.items()}


def translated(
    legs: dict[tuple[tuple[float, ...], tuple[float, ...]], tuple[float, float]],
) -> Case:
    """A body that is moved without turning by three slides, with limited lengths to points of the ground."""
    x, y = (sr.Body(name, mass=1, inertia=(1, 1, 1)) for name in "xy")
    tool = sr.Body("tool", mass=1, inertia=(1, 1, 1), position=(0, 0, 1))
    joints = [
        sr.Translational("slide_x", sr.ground, x, point=(0, 0, 0), axis=(1, 0, 0)),
        sr.Translational("slide_y", x, y, point=(0, 0, 0), axis=(0, 1, 0)),
        sr.Translational("slide_z", y, tool, point=(0, 0, 0), axis=(0, 0, 1)),
    ]
    limits: Limits = {
        sr.Length(sr.ground.point(*foot), tool.point(*corner), f"leg {n}"): pair
        for n, ((foot, corner), pair) in enumerate(legs.items(), start=1)
    }
    system = sr.System(sr.Model("translated", bodies=[x, y, tool], joints=joints))
    return system, tool.point(0, 0, 0)["x", "y", "z"], limits


def gough(turned: np.ndarray | None = None) -> Case:
    """A platform on six legs with a fixed orientation, a matrix."""
    feet = [(np.cos(a * DEGREE), np.sin(a * DEGREE), 0.0) for a in (10, 110, 130, 230, 250, 350)]
    corners = [
        (0.6 * np.cos(a * DEGREE), 0.6 * np.sin(a * DEGREE), 0.0) for a in (50, 70, 170, 190, 290, 310)
    ]
    if turned is not None:
        corners = [tuple(turned @ corner) for corner in corners]
    return translated(dict.fromkeys(zip(feet, corners, strict=True), (0.95, 1.45)))


def tilted() -> np.ndarray:
    """A tilted orientation for `gough`: 15° about z, -5° about y, 10° about x."""
    return about(2, 15) @ about(1, -5) @ about(0, 10)


def about(axis: int, degrees: float) -> np.ndarray:
    """The matrix of a turn about a coordinate axis."""
    c, s, found = cos(degrees * DEGREE), sin(degrees * DEGREE), np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    found[i, i], found[i, j], found[j, i], found[j, j] = c, -s, s, c
    return found


def puma() -> Case:
    """The first three hinges of a PUMA 560 with the centre of its wrist, without limits: a shell with a small void."""
    places, axes = [(0, 0, 0), (0, 0.1497, 0), (0.4318, 0.1497, 0)], [(0, 0, 1), (0, 1, 0), (0, 1, 0)]
    return spatial_arm(places, axes, (0.4318 + 0.0203, 0.1497, 0.4331))
