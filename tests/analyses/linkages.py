"""Linkages with more equations than a count of freedoms allows, and with branches and singular positions."""

import numpy as np

import sarrus as sr
from sarrus.model.joints import Joint

ROD_INERTIA = (
    1 / 600,
    1.01 / 12,
)  # of a rod of 1 m and 1 kg with a square section of 0.1 m: along it, across it
X, Y, Z = np.eye(3)


def rod(name: str, start: np.ndarray, end: np.ndarray, mass: float = 1.0) -> sr.Body:
    """A rod between two points, its frame in the middle and parallel to the ground's."""
    along = (end - start) / np.linalg.norm(end - start)
    axial, across = (mass * moment for moment in ROD_INERTIA)
    inertia = across * np.eye(3) + (axial - across) * np.outer(along, along)
    return sr.Body(name, mass=mass, inertia=inertia, position=(start + end) / 2)


def hinge(name: str, one: sr.Body, other: sr.Body, point: np.ndarray, axis: np.ndarray) -> sr.Revolute:
    return sr.Revolute(name, one, other, point=tuple(point), axis=tuple(axis))


def system(
    name: str, bodies: list[sr.Body], joints: list[Joint], gravity: np.ndarray = -9.81 * Y
) -> sr.System:
    return sr.System(sr.Model(name, bodies=bodies, joints=joints, gravity=tuple(gravity)))


def chain(name: str, points: np.ndarray, axes: np.ndarray, gravity: np.ndarray = -9.81 * Y) -> sr.System:
    """A loop of rods through the points, hinged at each of them; first and last point on the ground."""
    rods = [rod(f"rod_{n + 1}", *points[n : n + 2]) for n in range(len(points) - 1)]
    links = [sr.ground, *rods, sr.ground]
    joints = [hinge(f"hinge_{n + 1}", links[n], links[n + 1], points[n], axes[n]) for n in range(len(points))]
    return system(name, rods, joints, gravity)


def door() -> sr.System:
    """A door on two hinges on one upright line: five of its ten joint equations are redundant."""
    panel = sr.Body("panel", mass=20.0, inertia=(8.0, 6.0, 2.0), position=(0.4, 0, 1.0))
    hinges = [hinge(f"hinge_{n}", sr.ground, panel, np.array([0, 0, z]), Z) for n, z in ((1, 0.2), (2, 1.8))]
    return system("door", [panel], hinges, np.array([0.3, 1.0, -9.81]))


def crooked_door(angle: float = 0.02) -> sr.System:
    """A door whose upper hinge is inclined: the hinges contradict each other as soon as it turns; it is stuck."""
    panel = sr.Body("panel", mass=20.0, inertia=(8.0, 6.0, 2.0), position=(0.4, 0, 1.0))
    lower = hinge("hinge_1", sr.ground, panel, np.array([0, 0, 0.2]), Z)
    upper = hinge(
        "hinge_2", sr.ground, panel, np.array([0, 0, 1.8]), np.array([np.sin(angle), 0, np.cos(angle)])
    )
    return system("crooked door", [panel], [lower, upper])


def contradictory_door() -> sr.System:
    """A door whose hinges are 1.6 m apart on the wall and 1.5 m on the panel."""
    panel = sr.Body("panel", mass=20.0, inertia=(8.0, 6.0, 2.0))
    joints: list[Joint] = []
    for n, wall, there in ((1, 0.2, 0.2), (2, 1.8, 1.7)):
        frames = sr.ground.frame((0, 0, wall), z=(0, 0, 1)), panel.frame((0, 0, there), z=(0, 0, 1))
        joints.append(sr.Revolute(f"hinge_{n}", sr.ground, panel, frame_i=frames[0], frame_j=frames[1]))
    return system("contradictory door", [panel], joints)


def four_bar(
    crank: float, coupler: float, rocker: float, base: float, angle: float, side: int = 1
) -> sr.System:
    """A planar four-bar in the x-y plane; `side` chooses the branch: left or right of its diagonal."""
    return chain("four-bar", four_bar_points(crank, coupler, rocker, base, angle, side), np.tile(Z, (4, 1)))


def four_bar_points(
    crank: float, coupler: float, rocker: float, base: float, angle: float, side: int = 1
) -> np.ndarray:
    A, D = np.zeros(3), base * X
    B = crank * np.array([np.cos(angle), np.sin(angle), 0])
    diagonal = D - B
    length = np.linalg.norm(diagonal)
    along = (coupler**2 - rocker**2 + length**2) / (2 * length)
    up = side * np.sqrt(max(coupler**2 - along**2, 0.0))
    C = B + (along * diagonal + up * np.cross(Z, diagonal)) / length
    return np.array([A, B, C, D])


def parallelogram(angle: float = 1.0) -> sr.System:
    """Crank and rocker 1 m, coupler and base 2 m, started as a parallelogram."""
    return chain("parallelogram", parallelogram_points(angle), np.tile(Z, (4, 1)))


def parallelogram_points(angle: float) -> np.ndarray:
    B = np.array([np.cos(angle), np.sin(angle), 0])
    return np.array([np.zeros(3), B, B + 2 * X, 2 * X])


def slider_crank_in_line(angle: float = 0.7, crank: float = 1.0, rod_length: float = 2.5) -> sr.System:
    """A planar slider-crank whose slider goes through the crank's centre; dead centres at the angles 0 and π."""
    A, B = np.zeros(3), crank * np.array([np.cos(angle), np.sin(angle), 0])
    C = (B[0] + np.sqrt(rod_length**2 - B[1] ** 2)) * X
    arm, connecting = rod("crank", A, B), rod("rod", B, C)
    slider = sr.Body("slider", mass=1.0, inertia=(0.1, 0.1, 0.1), position=C)
    joints: list[Joint] = [hinge("centre", sr.ground, arm, A, Z), hinge("pin", arm, connecting, B, Z)]
    joints.append(hinge("wrist", connecting, slider, C, Z))
    joints.append(sr.Translational("guide", sr.ground, slider, point=tuple(C), axis=(1, 0, 0)))
    return system("in-line slider-crank", [arm, connecting, slider], joints)


def sarrus(lift: float = 1.2) -> sr.System:
    """Sarrus' linkage: two hinged arms in perpendicular planes carry a platform straight up and down."""
    platform = sr.Body("platform", mass=1.0, inertia=(0.2, 0.2, 0.3), position=lift * Z)
    bodies, joints = [platform], []
    for name, out, axis in (("a", X, Y), ("b", Y, X)):
        low, high = 0.5 * out, 0.5 * out + lift * Z
        knee = 0.5 * (low + high) + np.sqrt(1 - lift**2 / 4) * out
        lower, upper = rod(f"lower_{name}", low, knee), rod(f"upper_{name}", knee, high)
        links = [sr.ground, lower, upper, platform]
        points = [low, knee, high]
        joints += [hinge(f"{name}_{n + 1}", links[n], links[n + 1], points[n], axis) for n in range(3)]
        bodies += [lower, upper]
    return system("Sarrus linkage", bodies, joints, -9.81 * Z)


def bennett(
    turn: float = 1.1, a: float = 1.0, alpha: float = np.radians(50), beta: float = np.radians(80)
) -> sr.System:
    """Bennett's linkage: opposite links alike, sin α / a = sin β / b, four skew hinges and one degree of freedom."""
    b = a * np.sin(beta) / np.sin(alpha)
    ratio = np.sin((beta + alpha) / 2) / np.sin((beta - alpha) / 2)
    second = 2 * np.arctan2(ratio, np.tan(turn / 2))
    frames = [np.eye(4)]
    for length, twist, angle in ((a, alpha, second), (b, beta, -turn), (a, alpha, -second), (b, beta, turn)):
        frames.append(frames[-1] @ _screw_x(length, twist) @ _turn_z(angle))
    assert np.allclose(frames[4], np.eye(4), atol=1e-12), "the loop does not close"
    points, axes = (np.array([frame[:3, column] for frame in frames[:4]]) for column in (3, 2))
    # Ground is the link from the last hinge to the first one.
    return chain("Bennett linkage", points, axes)


def _screw_x(length: float, twist: float) -> np.ndarray:
    c, s = np.cos(twist), np.sin(twist)
    return np.array([[1, 0, 0, length], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1]])


def _turn_z(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])


def bricard() -> sr.System:
    """Bricard's linkage as in the IFToMM library: five rods of 1 m and 1 kg, six perpendicular hinges."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, -1, 0], [1, -1, 1], [0, -1, 1], [0, 0, 1]], dtype=float)
    return chain("Bricard linkage", points, np.array([Y, Z, X, Y, Z, X]))
