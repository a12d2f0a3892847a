"""Bodies that turn: free, tops, wheels on springs, gears."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

import sarrus as sr
from sarrus.algebra import Array

from .problem import Known, Problem, integrated, motion, stack


def spin(body: str) -> dict[str, list[str]]:
    """Names of what is compared of a free rotation: Euler parameters, and the angular velocity in global axes."""
    return {
        "positions": [f"{body}.e{n}" for n in range(4)],
        "velocities": [f"{body}.angular_velocity.{x}" for x in "xyz"],
    }


def free(
    name: str, inertia: tuple[float, float, float], w: tuple[float, float, float], until: float
) -> Problem:
    """A body without forces, by Euler's equations and ṗ = ½ p ∘ ω."""

    def make() -> tuple[sr.System, Any]:
        return sr.System(sr.Model("free", [sr.Body("body", 1.0, inertia, angular_velocity=w)])), None

    return Problem(name, make, until, partial(_free, inertia, w), spin("body"))


def _free(inertia: tuple[float, ...], w: tuple[float, ...], t: Array) -> Known:
    J = np.array(inertia)

    def f(t: float, y: Array) -> Array:
        return np.append(_rate(y[:4], y[4:]), np.cross(J * y[4:], y[4:]) / J)

    y = integrated(f, [1, 0, 0, 0, *w], t)
    return Known(t, y[:, :4], _global(y))


def _rate(p: Array, w: Array) -> Array:
    return 0.5 * np.append(-p[1:] @ w, p[0] * w + np.cross(p[1:], w))


def _global(y: Array) -> Array:
    """A(p) ω for rows p, ω."""
    e0, e, w = y[:, :1], y[:, 1:4], y[:, 4:7]
    return (2 * e0**2 - 1) * w + 2 * np.sum(e * w, axis=1)[:, None] * e + 2 * e0 * np.cross(e, w)


def top(name: str, speed: float, until: float) -> Problem:
    """A heavy symmetric top with its point on the ground, tilted by 0.5 rad; its axis is z of the body."""
    mass, J, height, tilt = 1.0, np.array([0.02, 0.02, 0.005]), 0.2, 0.5
    p0 = np.array([np.cos(tilt / 2), np.sin(tilt / 2), 0, 0])

    def make() -> tuple[sr.System, Any]:
        place = (0.0, -height * np.sin(tilt), height * np.cos(tilt))
        body = sr.Body("top", mass, tuple(J), position=place, orientation=tuple(p0))
        tip = sr.Spherical("tip", sr.ground, body, point=(0, 0, 0))
        system = sr.System(sr.Model("top", [body], [tip], gravity=(0, 0, -9.81)))
        v = np.zeros(system.nq)
        v[3:7] = _rate(p0, np.array([0, 0, speed]))
        return system, sr.assemble(system, system.q0, v)

    def f(t: float, y: Array) -> Array:
        p, w = y[:4], y[4:]
        about = J + mass * height**2 * np.array([1, 1, 0])
        up = np.array(
            [
                2 * (p[1] * p[3] - p[0] * p[2]),
                2 * (p[2] * p[3] + p[0] * p[1]),
                2 * (p[0] ** 2 + p[3] ** 2) - 1,
            ]
        )
        torque = np.cross([0, 0, height], -mass * 9.81 * up)
        return np.append(_rate(p, w), (torque - np.cross(w, about * w)) / about)

    def known(t: Array) -> Known:
        y = integrated(f, [*p0, 0, 0, speed], t)
        return Known(t, y[:, :4], _global(y))

    return Problem(name, make, until, known, spin("top"))


def coil(name: str, start: float, until: float, k: float = 2.0, J: float = 0.1, c: float = 0.0) -> Problem:
    """A wheel on a torsion spring, from rest at an angle; many revolutions count."""

    def make() -> tuple[sr.System, Any]:
        wheel = sr.Body("wheel", 1.0, (J, J, J))
        pin = sr.Revolute("pin", sr.ground, wheel, point=(0, 0, 0), axis=(0, 0, 1))
        spring = sr.RSDA("coil", sr.ground, wheel, point=(0, 0, 0), axis=(0, 0, 1), k=k, c=c, angle=-start)
        return sr.System(sr.Model("wheel", [wheel], [pin], [spring])), None

    def known(t: Array) -> Known:
        mean, w = c / (2 * J), np.sqrt(k / J - (c / (2 * J)) ** 2)
        decay = start * np.exp(-mean * t)
        x = decay * (np.cos(w * t) + mean / w * np.sin(w * t))
        return Known(t, stack(x - start), stack(-decay * (k / J / w) * np.sin(w * t)))

    return Problem(name, make, until, known, motion("pin.angle"))


def flywheel(t: Array) -> Known:
    """A constant torque for 5 s: 10⁴ rad/s at the end; the centre is 1 mm off the axis and loads the bearing."""
    mass, e, bend = 2.0, 1e-3, 2000.0
    angle, rate = 0.5 * bend * t**2, bend * t
    x = mass * e * (-np.sin(angle) * bend - np.cos(angle) * rate**2)
    y = mass * e * (np.cos(angle) * bend - np.sin(angle) * rate**2)
    return Known(t, stack(angle), stack(rate), stack(x, y))


def make_flywheel() -> tuple[sr.System, Any]:
    J, mass, e = 0.01, 2.0, 1e-3
    wheel = sr.Body("wheel", mass, (J, J, J), position=(e, 0, 0))
    pin = sr.Revolute("pin", sr.ground, wheel, point=(0, 0, 0), axis=(0, 0, 1))
    torque = sr.Torque("motor", wheel, (0, 0, 2000.0 * (J + mass * e**2)))
    return sr.System(sr.Model("flywheel", [wheel], [pin], [torque])), None


def gears(t: Array) -> Known:
    """Two wheels in mesh, ratio 3, a torque on the first and a spring on the second: one oscillator."""
    J1, J2, ratio, k, torque = 0.1, 0.5, 3.0, 20.0, 4.0
    # φ₁ = -3 φ₂: (J₁ + J₂ / 9) φ₁'' + k φ₁ / 9 = T
    w = np.sqrt(k / ratio**2 / (J1 + J2 / ratio**2))
    end = torque * ratio**2 / k
    one, rate = end * (1 - np.cos(w * t)), end * w * np.sin(w * t)
    return Known(t, stack(one, -one / ratio), stack(rate, -rate / ratio))


def make_gears() -> tuple[sr.System, Any]:
    wheels = [sr.Body(f"wheel_{n}", 1.0, (J, J, J), position=(n, 0, 0)) for n, J in enumerate((0.1, 0.5))]
    pins = [
        sr.Revolute(f"pin_{n}", sr.ground, wheel, point=(n, 0, 0), axis=(0, 0, 1))
        for n, wheel in enumerate(wheels)
    ]
    mesh = sr.Gear("mesh", "pin_0", "pin_1", ratio=-1 / 3)
    spring = sr.RSDA("coil", sr.ground, wheels[1], point=(1, 0, 0), axis=(0, 0, 1), k=20.0)
    motor = sr.Torque("motor", wheels[0], (0, 0, 4.0))
    return sr.System(sr.Model("gears", wheels, [*pins, mesh], [spring, motor])), None


ROTATIONS = (
    free("free body, about its middle axis", (1.0, 2.0, 3.0), (0.001, 2.0, 0.001), 30.0),
    free("free body, fast", (2.0, 3.0, 4.0), (50.0, 100.0, 20.0), 2.0),
    free("free disk", (1.0, 1.0, 1.9), (0.3, 0.0, 5.0), 20.0),
    top("top, fast", 200.0, 2.0),
    top("top, slow", 20.0, 5.0),
    coil("wheel on a coil", 1.0, 10.0),
    coil("wheel on a coil, 1e-6 rad", 1e-6, 10.0),
    coil("wheel on a coil, wound by 20 revolutions", 40 * np.pi, 10.0, k=5.0),
    coil("wheel on a coil, damped", 2.0, 10.0, c=0.1),
    Problem(
        "flywheel, to 10 000 rad/s",
        make_flywheel,
        5.0,
        flywheel,
        {**motion("pin.angle"), "reactions": ["pin.force.x", "pin.force.y"]},
    ),
    Problem(
        "gears",
        make_gears,
        10.0,
        gears,
        motion("pin_0.angle", "pin_1.angle"),
    ),
)
