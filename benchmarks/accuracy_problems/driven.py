"""Mechanisms with loops, drivers and more constraints than are needed, whose motion has one unknown or none."""

from __future__ import annotations

from typing import Any

import numpy as np

import sarrus as sr
from sarrus.algebra import Array
from sarrus.functions import sin

from .problem import Known, Problem, cart, integrated, motion, stack

G = 9.81


def speeding(t: Any) -> Any:
    return 5.0 * t + 0.5 * sin(3.0 * t)


def rotor(t: Array) -> Known:
    """An eccentric rotor whose angle is prescribed: the bearing carries m e times the square of its speed."""
    mass, e = 3.0, 0.01
    angle, rate, bend = 5 * t + 0.5 * np.sin(3 * t), 5 + 1.5 * np.cos(3 * t), -4.5 * np.sin(3 * t)
    x = mass * e * (-np.sin(angle) * bend - np.cos(angle) * rate**2)
    y = mass * e * (np.cos(angle) * bend - np.sin(angle) * rate**2)
    return Known(t, stack(angle), stack(rate), stack(x, y))


def make_rotor() -> tuple[sr.System, Any]:
    body = sr.Body("rotor", 3.0, (0.01, 0.01, 0.02), position=(0.01, 0, 0))
    loose = cart(1.0, "loose", position=(5, 0, 0))  # so that the model moves by itself, too
    pin = sr.Revolute("pin", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
    motor = sr.AngleDriver("motor", "pin", speeding)
    return sr.System(sr.Model("rotor", [body, loose], [pin], drivers=[motor])), None


CRANK, ROD, TURNING = 0.1, 0.4, 20.0


def slider_crank(t: Array) -> Known:
    """A crank at constant speed; the slider follows in closed form, and its mass loads the rod."""
    a = TURNING * t
    s, c = np.sin(a), np.cos(a)
    root = np.sqrt(ROD**2 - (CRANK * s) ** 2)
    x = CRANK * c + root
    v = -CRANK * s * TURNING - CRANK**2 * s * c * TURNING / root
    return Known(t, stack(x), stack(v))


def make_slider_crank() -> tuple[sr.System, Any]:
    crank = sr.Body("crank", 1.0, (1e-3,) * 3, position=(CRANK / 2, 0, 0))
    rod = sr.Body("rod", 1.0, (1e-2,) * 3, position=(CRANK + ROD / 2, 0, 0))
    slider = sr.Body("slider", 1.0, (1e-3,) * 3, position=(CRANK + ROD, 0, 0))
    joints = [
        sr.Revolute("A", sr.ground, crank, point=(0, 0, 0), axis=(0, 0, 1)),
        sr.Spherical("B", crank, rod, point=(CRANK, 0, 0)),
        sr.Revolute("C", rod, slider, point=(CRANK + ROD, 0, 0), axis=(0, 0, 1)),
        sr.Translational("guide", sr.ground, slider, point=(0, 0, 0), axis=(1, 0, 0)),
    ]
    motor = sr.AngleDriver("motor", "A", lambda t: TURNING * t)
    system = sr.System(sr.Model("slider-crank", [crank, rod, slider], joints, drivers=[motor]))
    return system, None


def door(t: Array) -> Known:
    """A door on two hinges, whose axis leans by 0.3 rad: a pendulum; four of its ten constraints are not needed."""
    lean, start, width = 0.3, 1.0, 0.8
    w2 = G * np.sin(lean) * (width / 2) / (0.25 * width**2 + width**2 / 12)
    y = integrated(lambda t, y: np.array([y[1], -w2 * np.sin(y[0])]), (start, 0.0), t)
    return Known(t, y[:, :1] - start, y[:, 1:])


def make_door() -> tuple[sr.System, Any]:
    lean, start, width, mass = 0.3, 1.0, 0.8, 20.0
    axis = np.array([np.sin(lean), 0, np.cos(lean)])
    down = np.array([np.cos(lean), 0, -np.sin(lean)])  # of the door's plane at rest
    across = np.cross(axis, down)
    wing = np.cos(start) * down + np.sin(start) * across
    J = mass * width**2 / 12
    matrix = J * (np.eye(3) - np.outer(wing, wing)) + 1e-3 * mass * np.outer(wing, wing)
    leaf = sr.Body("leaf", mass, matrix, position=tuple(width / 2 * wing))
    hinges = [
        sr.Revolute(name, sr.ground, leaf, point=tuple(h * axis), axis=tuple(axis))
        for name, h in (("low", -0.5), ("high", 0.5))
    ]
    return sr.System(sr.Model("door", [leaf], hinges, gravity=(0, 0, -G))), None


def parallel_crank(t: Array) -> Known:
    """Two cranks and a coupler that stays parallel: the coupler moves on a circle, three constraints are not needed."""
    start = 0.8
    w2 = G * (2.0 + 0.5 + 0.5) / (2.0 + 2 / 3)
    y = integrated(lambda t, y: np.array([y[1], -w2 * np.sin(y[0])]), (start, 0.0), t)
    return Known(t, y[:, :1] - start, y[:, 1:])


def make_parallel_crank() -> tuple[sr.System, Any]:
    s, c = np.sin(0.8), np.cos(0.8)
    cranks = [
        sr.Body(
            f"crank_{n}",
            1.0,
            (1 / 12, 1 / 12, 1e-3),
            position=(n + s / 2, 0, -c / 2),
            orientation=sr.AxisAngle((0, -1, 0), 0.8),
        )
        for n in range(2)
    ]
    coupler = sr.Body("coupler", 2.0, (0.1, 0.1, 0.1), position=(0.5 + s, 0, -c))
    bottom = [sr.Revolute(f"A{n}", sr.ground, cranks[n], point=(n, 0, 0), axis=(0, -1, 0)) for n in range(2)]
    top = [sr.Revolute(f"B{n}", cranks[n], coupler, point=(n + s, 0, -c), axis=(0, -1, 0)) for n in range(2)]
    return sr.System(
        sr.Model("parallel crank", [*cranks, coupler], [*bottom, *top], gravity=(0, 0, -G))
    ), None


def rack(t: Array) -> Known:
    """A pinion with a weight off its axis on a rack with a spring: one equation."""
    J, mass, radius, k, weight, arm = 0.02, 2.0, 0.1, 300.0, 0.5, 0.15

    def f(t: float, y: Array) -> Array:
        inertia = J + weight * arm**2 + mass * radius**2
        return np.array([y[1], (-k * radius**2 * y[0] - weight * G * arm * np.cos(y[0])) / inertia])

    y = integrated(f, (0.0, 0.0), t)
    return Known(t, stack(y[:, 0], radius * y[:, 0]), stack(y[:, 1], radius * y[:, 1]))


def make_rack() -> tuple[sr.System, Any]:
    pinion = sr.Body("pinion", 0.5, (0.02,) * 3, position=(0.15, 0, 0))
    bar = cart(2.0, "bar", position=(0, 0.1, 0))
    joints = [
        sr.Revolute("pin", sr.ground, pinion, point=(0, 0, 0), axis=(0, 0, 1)),
        sr.Translational("guide", sr.ground, bar, point=(0, 0.1, 0), axis=(1, 0, 0)),
        sr.RackAndPinion("teeth", "guide", "pin", radius=0.1),
    ]
    spring = sr.TSDA("spring", sr.ground.point(-1, 0.1, 0), bar.point(0, 0, 0), k=300.0, length=1.0)
    return sr.System(sr.Model("rack", [pinion, bar], joints, [spring], gravity=(0, -G, 0))), None


DRIVEN = (
    Problem(
        "driven rotor", make_rotor, 5.0, rotor,
        motion("pin.angle") | {"reactions": ["pin.force.x", "pin.force.y"]},
    ),
    Problem(
        "driven slider-crank", make_slider_crank, 2.0, slider_crank,
        motion("slider.x"),
    ),
    Problem(
        "door on two hinges", make_door, 10.0, door,
        motion("low.angle"),
    ),
    Problem(
        "parallel crank", make_parallel_crank, 10.0, parallel_crank,
        motion("A0.angle"),
    ),
    Problem(
        "rack and pinion", make_rack, 5.0, rack,
        motion("pin.angle", "bar.x"),
    ),
)  # fmt: skip
