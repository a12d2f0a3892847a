"""Pendulums: all sizes and amplitudes, double, spatial, on carts, chaotic."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from scipy.special import ellipj, ellipk

import sarrus as sr
from sarrus.algebra import Array
from sarrus.functions import sin

from .problem import Known, Problem, cart, integrated, motion, stack

G = 9.81
SWING = motion("pin.angle") | {"reactions": ["pin.force.x", "pin.force.z"]}


def pendulum(
    name: str, until: float, start: float, length: float = 1.0, g: float = G, mass: float = 1.0
) -> Problem:
    """A ball of little inertia on a pin, from rest at an angle from the lowest position."""

    def make() -> tuple[sr.System, Any]:
        return _pendulum(mass, length, start, g), None

    return Problem(name, make, until, partial(_elliptic, start, length, g, mass), SWING)


def _pendulum(mass: float, length: float, start: float, g: float) -> sr.System:
    """The centre of a body a length below its pin, turned about -y by an angle."""
    place = (length * np.sin(start), 0.0, -length * np.cos(start))
    body = sr.Body("bob", mass, (1e-3 * mass * length**2,) * 3, position=place)
    pin = sr.Revolute("pin", sr.ground, body, point=(0, 0, 0), axis=(0, -1, 0))
    return sr.System(sr.Model("pendulum", [body], [pin], gravity=(0, 0, -g)))


def _elliptic(start: float, length: float, g: float, mass: float, t: Array) -> Known:
    """θ = 2 asin(k sn(K - ω t)), and the reaction from m a - m g; the angle is counted from the start."""
    w = np.sqrt(g * length / (length**2 * 1.001))
    k = np.sin(start / 2)
    u = ellipk(k**2) - w * t
    sn, cn, dn, _ = ellipj(u, k**2)
    angle = 2 * np.arcsin(k * sn)
    rate = -2 * k * w * cn
    return _swing(t, angle, rate, -(w**2) * np.sin(angle), start, length, g, mass)


def _swing(
    t: Array, angle: Array, rate: Array, bend: Array, start: float, length: float, g: float, mass: float
) -> Known:
    x = mass * length * (np.cos(angle) * bend - np.sin(angle) * rate**2)
    z = mass * length * (np.sin(angle) * bend + np.cos(angle) * rate**2) + mass * g
    return Known(t, stack(angle - start), stack(rate), stack(x, z))


def turning(t: Array) -> Known:
    """Over the top: θ = 2 am(ω₀ t / 2, 4 ω² / ω₀²)."""
    w2, speed = G / 1.001, 10.0
    parameter = 4 * w2 / speed**2
    _, cn, dn, am = ellipj(0.5 * speed * t, parameter)
    angle, rate = 2 * am, speed * dn
    return _swing(t, angle, rate, -w2 * np.sin(angle), 0.0, 1.0, G, 1.0)


def make_turning() -> tuple[sr.System, Any]:
    system = _pendulum(1.0, 1.0, 0.0, G)
    return system, sr.assemble(system, rates={"pin": 10.0})


def links(count: int, angles: tuple[float, ...], name: str, until: float) -> Problem:
    """Rods of 1 m and 1 kg in a row, in a plane, from rest; angles from the lowest position."""

    def make() -> tuple[sr.System, Any]:
        ends = np.cumsum([[0, 0], *([np.sin(a), -np.cos(a)] for a in angles)], axis=0)
        bodies = [
            sr.Body(
                f"rod_{n}",
                1.0,
                (1 / 12, 1 / 12, 1e-3),
                position=(x, 0, z),
                orientation=sr.AxisAngle((0, -1, 0), a),
            )
            for n, (a, (x, z)) in enumerate(zip(angles, 0.5 * (ends[1:] + ends[:-1]), strict=True))
        ]
        pins = [
            sr.Revolute(f"pin_{n}", one, two, point=(ends[n, 0], 0, ends[n, 1]), axis=(0, -1, 0))
            for n, (one, two) in enumerate(zip([sr.ground, *bodies], bodies, strict=False))
        ]
        return sr.System(sr.Model("rods", bodies, pins, gravity=(0, 0, -G))), None

    def f(t: float, y: Array) -> Array:
        a, w = y[:count], y[count:]
        beyond = count - np.arange(count)
        weight = (
            np.minimum.outer(beyond, beyond) - 0.5
        )  # of rods beyond both, of which the nearer counts half
        weight = weight - np.diag(np.full(count, 0.5 - 1 / 3))
        difference = a[:, None] - a[None]
        M, h = weight * np.cos(difference), (weight * np.sin(difference)) @ w**2
        return np.append(w, np.linalg.solve(M, -h - G * (beyond - 0.5) * np.sin(a)))

    def known(t: Array) -> Known:
        y = integrated(f, [*angles, *([0.0] * count)], t)
        a, w = y[:, :count], y[:, count:]
        relative = np.diff(a, axis=1, prepend=0) - np.diff(angles, prepend=0)
        return Known(t, relative, np.diff(w, axis=1, prepend=0))

    return Problem(name, make, until, known, motion(*(f"pin_{n}.angle" for n in range(count))))


def cart_pole(name: str, mass: float, until: float, start: float = 2.0) -> Problem:
    """A pole of 1 kg whose centre is 0.5 m from its pin on a cart without friction."""

    def make() -> tuple[sr.System, Any]:
        base = cart(mass, "cart")
        inertia = 1 / 12
        pole = sr.Body(
            "pole", 1.0, (inertia,) * 3, position=(0.5 * np.sin(start), 0, -0.5 * np.cos(start)),
        )  # fmt: skip
        joints = [
            sr.Translational("guide", sr.ground, base, point=(0, 0, 0), axis=(1, 0, 0)),
            sr.Revolute("pin", base, pole, point=(0, 0, 0), axis=(0, -1, 0)),
        ]
        return sr.System(sr.Model("cart and pole", [base, pole], joints, gravity=(0, 0, -G))), None

    def f(t: float, y: Array) -> Array:
        """The centre of both does not move along x, which leaves one equation for the angle."""
        a, w = y
        share = 1.0 / (mass + 1.0)
        M = 1 / 12 + 0.25 * (1 - share * np.cos(a) ** 2)
        return np.array([w, (-0.25 * share * np.sin(a) * np.cos(a) * w**2 - 0.5 * G * np.sin(a)) / M])

    def known(t: Array) -> Known:
        y = integrated(f, (start, 0.0), t)
        share = 0.5 / (mass + 1.0)
        x, v = -share * (np.sin(y[:, 0]) - np.sin(start)), -share * np.cos(y[:, 0]) * y[:, 1]
        return Known(t, stack(y[:, 0] - start, x), stack(y[:, 1], v))

    return Problem(name, make, until, known, motion("pin.angle", "cart.x"))


def spherical(name: str, until: float, start: float, speed: float) -> Problem:
    """A ball on a string of 1 m, which moves on a sphere."""

    def make() -> tuple[sr.System, Any]:
        body = sr.Body("bob", 1.0, (0.01, 0.01, 0.01), position=(np.sin(start), 0, -np.cos(start)))
        string = sr.Distance("string", sr.ground.point(0, 0, 0), body.point(0, 0, 0))
        system = sr.System(sr.Model("spherical", [body], [string], gravity=(0, 0, -G)))
        v = np.zeros(system.nq)
        v[1] = speed
        return system, sr.assemble(system, system.q0, v)

    def f(t: float, y: Array) -> Array:
        r, v = y[:3], y[3:]
        down = np.array([0, 0, -G])
        return np.append(v, down - (r @ down + v @ v) / (r @ r) * r)

    def known(t: Array) -> Known:
        y = integrated(f, [np.sin(start), 0, -np.cos(start), 0, speed, 0], t)
        return Known(t, y[:, :3], y[:, 3:])

    return Problem(name, make, until, known, motion("bob.x", "bob.y", "bob.z"))


def kapitza() -> Problem:
    """Upside down on a pivot that vibrates at 100 Hz by 2 cm: it stands."""
    amplitude, w, start = 0.02, 200 * np.pi, 0.2

    def make() -> tuple[sr.System, Any]:
        base = cart(1.0, "base")
        bob = sr.Body("bob", 1.0, (1e-3,) * 3, position=(np.sin(start), 0, np.cos(start)))
        joints = [
            sr.Translational("guide", sr.ground, base, point=(0, 0, 0), axis=(0, 0, 1)),
            sr.Revolute("pin", base, bob, point=(0, 0, 0), axis=(0, 1, 0)),
        ]
        shaker = sr.DisplacementDriver("shaker", "guide", motion=lambda t: 0.02 * sin(200 * np.pi * t))
        model = sr.Model("Kapitza", [base, bob], joints, gravity=(0, 0, -G), drivers=[shaker])
        system = sr.System(model)
        v = np.zeros(system.nq)
        v[2::7] = amplitude * w
        return system, sr.assemble(system, system.q0, v)

    def f(t: float, y: Array) -> Array:
        return np.array([y[1], (G - amplitude * w**2 * np.sin(w * t)) * np.sin(y[0]) / 1.001])

    def known(t: Array) -> Known:
        y = integrated(f, (start, 0.0), t, max_step=1e-3)
        return Known(t, y[:, :1] - start, y[:, 1:])

    return Problem("Kapitza's pendulum", make, 2.0, known, motion("pin.angle"))


def near_the_top(t: Array) -> Known:
    """From 179.9°: elliptic functions near modulus 1 lose digits, so it is integrated."""
    start = np.radians(179.9)
    y = integrated(lambda t, y: np.array([y[1], -G / 1.001 * np.sin(y[0])]), (start, 0.0), t)
    return _swing(t, y[:, 0], y[:, 1], -G / 1.001 * np.sin(y[:, 0]), start, 1.0, G, 1.0)


def make_near_the_top() -> tuple[sr.System, Any]:
    return _pendulum(1.0, 1.0, float(np.radians(179.9)), G), None


PENDULUMS = (
    pendulum("pendulum, from the horizontal", 10.0, np.pi / 2),
    pendulum("pendulum, 2000 s", 2000.0, np.pi / 2),
    pendulum("pendulum, 1e-4 rad", 10.0, 1e-4),
    pendulum("pendulum, 1e-6 rad", 10.0, 1e-6),
    pendulum("pendulum of 1 mm", 0.3, 1.0, length=1e-3, mass=1e-6),
    pendulum("pendulum of 1 km", 300.0, 1.0, length=1e3, mass=1e6),
    Problem("pendulum, over the top", make_turning, 10.0, turning, SWING),
    Problem("pendulum, from 179.9 degrees", make_near_the_top, 10.0, near_the_top, SWING),
    links(2, (0.6, 0.3), "double pendulum, calm", 20.0),
    links(2, (2.0, 2.5), "double pendulum, wild for 3 s", 3.0),
    links(2, (2.0, 2.5), "double pendulum, chaotic for 20 s", 20.0),
    links(4, (0.5, 0.8, 0.2, -0.4), "chain of four rods", 5.0),
    spherical("conical pendulum", 10.0, 0.5, float(np.sqrt(G * np.sin(0.5) * np.tan(0.5)))),
    spherical("spherical pendulum", 10.0, 1.0, 1.0),
    cart_pole("cart and pole", 1.0, 10.0),
    cart_pole("cart and pole, cart of 1e-6 kg", 1e-6, 5.0),
    kapitza(),
)
