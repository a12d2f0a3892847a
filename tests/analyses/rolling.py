"""Mechanisms that roll without slip, and their motions by other routes."""

import numpy as np
from scipy.integrate import solve_ivp

import sarrus as sr

G, M, R = 9.81, 2.0, 0.3
I_T, I_A = 0.25 * M * R**2, 0.5 * M * R**2  # of a thin disc, about a diameter and about its axis


def upright(slope: float = 0.0, kind: type = sr.RollingWheel) -> sr.System:
    """A disc upright on a plane that falls along x by an angle."""
    normal, along = (np.sin(slope), 0.0, np.cos(slope)), (np.cos(slope), 0.0, -np.sin(slope))
    disc = sr.Body("disc", mass=M, inertia=(I_T, I_A, I_T), position=tuple(R * np.array(normal)))
    plane = sr.ground.frame((0, 0, 0), x=along, z=normal)
    joint = kind("rolls", center=disc.point(0, 0, 0), plane=plane, radius=R, axis=(0, 1, 0))
    return sr.System(sr.Model("incline", [disc], [joint], gravity=(0, 0, -G)))


def leaning(lean: float, omega: tuple[float, float, float], **spring: float) -> sr.System:
    """A coin that leans about x by an angle, with the angular velocity [rad/s] in global axes."""
    axis, up = np.array([0.0, np.cos(lean), np.sin(lean)]), np.array([0.0, -np.sin(lean), np.cos(lean)])
    disc = sr.Body(
        "disc", mass=M, inertia=(I_T, I_A, I_T), position=(0, 0, R * np.cos(lean)),
        orientation=sr.AxisAngle((1, 0, 0), lean), angular_velocity=omega,
        velocity=tuple(np.cross(omega, R * up)),
    )  # fmt: skip
    joint = sr.RollingDisc(
        "rolls", center=disc.point(0, 0, 0), plane=sr.ground.frame((0, 0, 0)), radius=R, axis=tuple(axis)
    )
    forces = []
    if spring:
        forces = [sr.TSDA("spring", sr.ground.point(0, 0, 1), disc.point(0.1, 0, 0), length=0.5, **spring)]
    return sr.System(sr.Model("coin", [disc], [joint], forces=forces, gravity=(0, 0, -G)))


def coin(lean: float, omega: tuple[float, float, float], t: float) -> np.ndarray:
    """The centre (3,) at a time: Euler's equations about the contact in axes e1 level, e2 along the axis of the coin.

    The frame (e1, e2, e3) has e3 in the coin, up to its highest point; lean θ about e1, heading ψ about z, with
    ω = (θ̇, spin, w3). Angular momentum about the centre, H' = r x F with F = m (a + g), a = d/dt (ω x R e3).
    """

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        psi, theta, w1, w2, w3, *_ = y
        s, c = np.sin(theta), np.cos(theta)
        turn = w3 / c  # ψ̇ of the frame: its angular velocity is (θ̇, ψ̇ s, ψ̇ c)
        frame = np.array([w1, turn * s, w3])
        w, up = np.array([w1, w2, w3]), np.array([0.0, s, c])
        arm, inertia = np.array([0.0, 0.0, -R]), np.array([I_T, I_A, I_T])
        # J ẇ + frame x J w = arm x m (ẇ x e3 R + frame x (w x e3 R) + g up)
        e3 = np.array([0.0, 0.0, 1.0])

        def moment(w_dot: np.ndarray) -> np.ndarray:
            a = R * np.cross(w_dot, e3) + np.cross(frame, R * np.cross(w, e3))
            return inertia * w_dot + np.cross(frame, inertia * w) - np.cross(arm, M * (a + G * up))

        constant = moment(np.zeros(3))
        w_dot = np.linalg.solve(np.column_stack([moment(e) - constant for e in np.eye(3)]), -constant)
        v = R * np.cross(w, e3)
        level, across = np.array([np.cos(psi), np.sin(psi)]), np.array([-np.sin(psi), np.cos(psi)])
        flat = v[0] * level + (c * v[1] - s * v[2]) * across
        return np.array([turn, w1, *w_dot, *flat])

    s, c = np.sin(lean), np.cos(lean)
    w1, wy, wz = omega
    start = [0.0, lean, w1, wy * c + wz * s, -wy * s + wz * c, 0.0, 0.0]
    end = solve_ivp(rates, (0.0, t), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    return np.array([end[5], end[6], R * np.cos(end[1])])


def sleigh(offset: float = 0.2) -> sr.System:
    """Chaplygin's sleigh: a plate that slides on a plane, with an edge behind its centre of mass."""
    plate = sr.Body(
        "plate",
        mass=M,
        inertia=(0.1, 0.1, 0.15),
        velocity=(0.4, 1.5 * offset, 0),
        angular_velocity=(0, 0, 1.5),
    )
    level = sr.Planar("level", sr.ground, plate, point=(0, 0, 0), axis=(0, 0, 1))
    edge = sr.KnifeEdge("edge", point=plate.point(-offset, 0, 0), axis=(0, 1, 0))
    return sr.System(sr.Model("sleigh", [plate], [level, edge]))


def turntable(speed: float = 2.0) -> sr.System:
    """A homogeneous sphere on a driven turntable, at rest in space at the start."""
    table = sr.Body("table", mass=5, inertia=(1, 1, 1), angular_velocity=(0, 0, speed))
    r = 0.05
    ball = sr.Body("ball", mass=0.5, inertia=(0.4 * 0.5 * r**2,) * 3, position=(0.4, 0, r), velocity=(0, 0.1, 0),
                   angular_velocity=(14.0, 0, 0))  # fmt: skip
    pin = sr.Revolute("pin", sr.ground, table, point=(0, 0, 0), axis=(0, 0, 1))
    drive = sr.AngleDriver("drive", "pin", f"{speed}*t")
    rolls = sr.RollingSphere("rolls", center=ball.point(0, 0, 0), plane=table.frame((0, 0, 0)), radius=r)
    return sr.System(sr.Model("turntable", [table, ball], [pin, rolls], drivers=[drive], gravity=(0, 0, -G)))
