"""What touches, sticks and stops: contact, friction, stops, impacts, tyres that lift off.

Their laws are written down here a second time, in plain Python, and integrated by SciPy.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import sarrus as sr
from sarrus.algebra import Array
from sarrus.functions import positive, sin

from .problem import Column, Known, Problem, cart, integrated, motion, slide, stack

G = 9.81
VERTICAL = motion("ball.z")


def ramp(x: float, width: float) -> float:
    """0, then x, with a corner that is rounded over a width."""
    u = min(max(x / width + 0.5, 0.0), 1.0)
    return width * (u**3 - u**4 / 2) + max(x - width / 2, 0.0)


def step(x: float, width: float) -> float:
    u = min(max(x / width + 0.5, 0.0), 1.0)
    return u * u * (3 - 2 * u)


def dropped(
    name: str, stiffness: float, damping: float, until: float, height: float = 0.1, exponent: float = 1.5
) -> Problem:
    """A ball of 1 kg and radius 5 cm that falls on a plane."""

    def make() -> tuple[sr.System, Any]:
        body = sr.Body("ball", 1.0, (1e-3,) * 3, position=(0, 0, 0.05 + height))
        plane = sr.ground.frame((0, 0, 0), z=(0, 0, 1))
        touch = sr.SphereContact(
            "touch", body.point(0, 0, 0), plane, 0.05, stiffness=stiffness, exponent=exponent, damping=damping
        )
        return sr.System(sr.Model("ball", [body], forces=[touch], gravity=(0, 0, -G))), None

    def f(t: float, y: Array) -> Array:
        N = stiffness * ramp(0.05 - y[0], 1e-4) ** exponent * ramp(1 - damping * y[1], 0.25)
        return np.array([y[1], N - G])

    def known(t: Array) -> Known:
        y = integrated(f, (0.05 + height, 0.0), t, max_step=1e-3)
        return Known(t, y[:, :1], y[:, 1:])

    return Problem(name, make, until, known, VERTICAL, smooth=False)


def bouncing(t: Array) -> Known:
    """From 1 m with restitution 0.8: parabolas."""
    times, e = [np.sqrt(2 / G)], 0.8
    speed = e * G * times[0]
    z, v = 1 - 0.5 * G * t**2, -G * t
    while times[-1] < t[-1]:
        since = t - times[-1]
        later = since >= 0
        z = np.where(later, speed * since - 0.5 * G * since**2, z)
        v = np.where(later, speed - G * since, v)
        times.append(times[-1] + 2 * speed / G)
        speed *= e
    return Known(t, stack(z), stack(v))


def make_bouncing() -> tuple[sr.System, Any]:
    body = sr.Body("ball", 1.0, (1e-3,) * 3, position=(0, 0, 1))
    return sr.System(sr.Model("ball", [body], gravity=(0, 0, -G))), None


def braked(
    name: str, until: float, speed: float, spring: float = 0.0, pull: float = 0.0, creep: float = 1e-3
) -> Problem:
    """A mass that slides with dry friction, by itself or on a spring whose foot moves (stick and slip)."""
    mu, static, stribeck, load = 0.2, 0.3, 0.02, G

    def make() -> tuple[sr.System, Any]:
        body = cart(1.0, velocity=(0.0 if spring else speed, 0, 0))
        rub = sr.DisplacementFriction(
            "rub", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0), load=load, mu=mu, mu_static=static,
            stribeck=stribeck, creep=creep,
        )  # fmt: skip
        forces: list[Any] = [rub]
        if spring:
            center = body.point(0, 0, 0)
            forces += [
                sr.TSDA("spring", sr.ground.point(-1, 0, 0), center, k=spring, length=1.0),
                sr.PointForce("pull", center, (1, 0, 0), factor=lambda t: pull * t),
            ]
        return slide(1.0, *forces, body=body), None

    def f(t: float, y: Array) -> Array:
        u = y[1]
        friction = load * (mu + (static - mu) * np.exp(-((u / stribeck) ** 2))) * np.tanh(u / creep)
        return np.array([u, pull * t - spring * y[0] - friction])

    def known(t: Array) -> Known:
        start = (0.0, 0.0 if spring else speed)
        y = integrated(f, start, t, max_step=0.01)
        return Known(t, y[:, :1], y[:, 1:])

    return Problem(name, make, until, known, motion("mass.x"), smooth=False)


def stopped(name: str, stiffness: float, until: float, clearance: float = 0.05) -> Problem:
    """A mass on a soft spring between two stops."""
    k = 10.0

    def make() -> tuple[sr.System, Any]:
        body = cart(1.0, velocity=(2.0, 0, 0))
        where = {"point": (0, 0, 0), "axis": (1, 0, 0)}
        stop = sr.DisplacementStop(
            "stops",
            sr.ground,
            body,
            stiffness=stiffness,
            lower=-clearance,
            upper=clearance,
            rounding=1e-3,
            **where,
        )
        spring = sr.TSDA("spring", sr.ground.point(-1, 0, 0), body.point(0, 0, 0), k=k, length=1.0)
        return slide(1.0, stop, spring, body=body), None

    def f(t: float, y: Array) -> Array:
        x, v = y
        push = stiffness * (ramp(x - clearance, 1e-3) - ramp(-x - clearance, 1e-3))
        return np.array([v, -k * x - push])

    def known(t: Array) -> Known:
        y = integrated(f, (0.0, 2.0), t, max_step=1e-3)
        return Known(t, y[:, :1], y[:, 1:])

    return Problem(name, make, until, known, motion("mass.x"), smooth=False)


def quarter_car(name: str, height: float, until: float) -> Problem:
    """A quarter of a car over a bump of 0.1 s after 1 s; over a high one the wheel lifts off."""
    sprung, wheel, k, c, tyre, damping, radius, width = 350.0, 40.0, 2e4, 1500.0, 2e5, 100.0, 0.3, 1e-3
    begins, takes = 1.0, 0.1

    def road(t: Any) -> Any:
        s = (t - begins) / takes
        return height * sin(np.pi * s) ** 4 * positive(s) * positive(1 - s)

    rest = radius - (sprung + wheel) * G / tyre
    length = 0.5 + sprung * G / k

    def make() -> tuple[sr.System, Any]:
        bodies = [
            sr.Body("wheel", wheel, (1.0,) * 3, position=(0, 0, rest)),
            sr.Body("car", sprung, (10.0,) * 3, position=(0, 0, rest + 0.5)),
        ]
        guides = [
            sr.Translational(f"guide_{b.name}", sr.ground, b, point=(0, 0, 0), axis=(0, 0, 1)) for b in bodies
        ]
        hub, seat = (b.point(0, 0, 0) for b in bodies)
        forces = [
            sr.TSDA("spring", hub, seat, k=k, c=c, length=length),
            sr.RoadTyre("tyre", hub, tyre, damping, radius, bump=road, rounding=width),
        ]
        return sr.System(sr.Model("quarter car", bodies, guides, forces, gravity=(0, 0, -G))), None

    def f(t: float, y: Array) -> Array:
        z, s, v, u = y
        phase = (t - begins) / takes
        h = dh = 0.0
        if 0 < phase < 1:
            sine, cosine = np.sin(np.pi * phase), np.cos(np.pi * phase)
            h, dh = height * sine**4, 4 * height * sine**3 * cosine * np.pi / takes
        depth = radius - (z - h)
        F = step(depth, width) * ramp(tyre * depth + damping * (dh - v), tyre * width)
        push = k * (length - (s - z)) - c * (u - v)
        return np.array([v, u, (F - push) / wheel - G, push / sprung - G])

    def known(t: Array) -> Known:
        y = integrated(f, (rest, rest + 0.5, 0, 0), t, stops=(begins, begins + takes), max_step=2e-3)
        return Known(t, y[:, :2], y[:, 2:])

    return Problem(name, make, until, known, motion("wheel.z", "car.z"), smooth=False)


def rolling(t: Array) -> Known:
    """A ball that is thrown without spin slides and comes to roll; contact at rest, so that only friction acts."""
    mass, radius, J, mu, creep = 2.0, 0.1, 0.4 * 2.0 * 0.01, 0.2, 1e-3
    load = mass * G

    def f(t: float, y: Array) -> Array:
        slip = y[1] - y[2] * radius
        F = -mu * load * slip / np.sqrt(slip**2 + creep**2)
        return np.array([y[1], F / mass, -F * radius / J])

    y = integrated(f, (0.0, 2.0, 0.0), t, method="Radau", rtol=1e-11, atol=1e-13, max_step=0.01)
    return Known(t, y[:, :1], np.stack([y[:, 1], y[:, 2] * radius], axis=1))


def make_rolling() -> tuple[sr.System, Any]:
    sunk = 2.0 * G / 1e6
    body = sr.Body("ball", 2.0, (0.4 * 2.0 * 0.01,) * 3, position=(0, 0, 0.1 - sunk), velocity=(2.0, 0, 0))
    plane = sr.ground.frame((0, 0, 0), z=(0, 0, 1))
    touch = sr.SphereContact(
        "touch", body.point(0, 0, 0), plane, 0.1, stiffness=1e6, damping=0.5, mu=0.2, rounding=1e-6
    )
    return sr.System(sr.Model("rolling", [body], forces=[touch], gravity=(0, 0, -G))), None


ROLLING: dict[str, list[str | Column]] = {
    "positions": ["ball.x"],
    "velocities": ["ball.velocity.x", Column({"ball.angular_velocity.y": 0.1})],
}

CONTACTS = (
    dropped("dropped ball, hard", 1e7, 0.2, 1.0),
    dropped("dropped ball, soft", 1e4, 0.1, 1.0, exponent=1.0),
    dropped("dropped ball, without loss", 1e6, 0.0, 1.0),
    Problem(
        "bouncing ball, impacts",
        make_bouncing,
        2.5,
        bouncing,
        VERTICAL,
        smooth=False,
        events=(sr.Event("ball.z", direction=-1, reset=sr.Impact(0.8)),),
    ),
    braked("mass braked by friction", 2.0, 2.0),
    braked("stick and slip", 3.0, 0.0, spring=400.0, pull=20.0),
    stopped("mass between soft stops", 1e4, 3.0),
    stopped("mass between hard stops", 1e7, 3.0),
    quarter_car("quarter car over a bump", 0.03, 3.0),
    quarter_car("quarter car that lifts off", 0.12, 3.0),
    Problem("ball that slides, then rolls", make_rolling, 1.5, rolling, ROLLING, smooth=False, exact=1e-6),
)
