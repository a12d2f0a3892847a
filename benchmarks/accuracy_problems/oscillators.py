"""Masses on springs, free: all sizes and frequencies, damped, stiff, light, long."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from scipy.special import ellipj

import sarrus as sr
from sarrus.algebra import Array

from .problem import Known, Problem, cart, motion, slide, stack

READ = motion("mass.x")


def oscillator(
    name: str, mass: float, k: float, amplitude: float, until: float, c: float = 0.0, speed: float = 0.0
) -> Problem:
    """m x'' + c x' + k x = 0 from an amplitude; the spring is as long as the motion is large, ten times."""

    def make() -> tuple[sr.System, Any]:
        length = 10 * (amplitude + abs(speed) * np.sqrt(mass / k))
        body = cart(mass, position=(amplitude, 0, 0), velocity=(speed, 0, 0))
        foot = sr.ground.point(-length, 0, 0)
        return slide(
            mass, sr.TSDA("spring", foot, body.point(0, 0, 0), k=k, length=length, c=c), body=body
        ), None

    return Problem(name, make, until, partial(_damped, mass, k, c, amplitude, speed), READ)


def _damped(mass: float, k: float, c: float, amplitude: float, speed: float, t: Array) -> Known:
    """The closed form; the same for roots that are complex and real."""
    mean, root = -c / (2 * mass), np.emath.sqrt((c / (2 * mass)) ** 2 - k / mass)
    one, two = mean + root, mean - root
    a = (speed - two * amplitude) / (one - two)
    b = amplitude - a
    x, v = a * np.exp(one * t) + b * np.exp(two * t), a * one * np.exp(one * t) + b * two * np.exp(two * t)
    return Known(t, stack(np.real(x)), stack(np.real(v)))


def two_masses(name: str, masses: tuple[float, float], k: tuple[float, float], until: float) -> Problem:
    """A mass on a spring and another one on it, pulled so that both frequencies are excited."""
    start = np.array([0.01, 0.03])

    def make() -> tuple[sr.System, Any]:
        bodies = [cart(m, f"mass_{n}", position=(n + start[n], 0, 0)) for n, m in enumerate(masses)]
        points = [sr.ground.point(-1, 0, 0), *(body.point(0, 0, 0) for body in bodies)]
        guides = [
            sr.Translational(f"guide_{n}", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
            for n, body in enumerate(bodies)
        ]
        springs = [sr.TSDA(f"spring_{n}", points[n], points[n + 1], k=k[n], length=1.0) for n in range(2)]
        return sr.System(sr.Model("two masses", bodies, guides, springs)), None

    def known(t: Array) -> Known:
        K = np.array([[k[0] + k[1], -k[1]], [-k[1], k[1]]]) / np.array(masses)[:, None]
        A = np.block([[np.zeros((2, 2)), np.eye(2)], [-K, np.zeros((2, 2))]])
        w, V = np.linalg.eig(A)
        parts = np.linalg.solve(V, np.append(start, [0, 0]))
        y = np.real(np.exp(np.outer(t, w)) * parts @ V.T)
        return Known(t, y[:, :2] + [0, 1], y[:, 2:])

    return Problem(name, make, until, known, motion("mass_0.x", "mass_1.x"))


def hardening(t: Array) -> Known:
    """m x'' + k x + k₃ x³ = 0 from rest: x = A cn(ω t, κ)."""
    mass, k, cubic, A = 1.0, 10.0, 4000.0, 0.2
    frequency = np.sqrt((k + cubic * A**2) / mass)
    parameter = cubic * A**2 / (2 * (k + cubic * A**2))
    sn, cn, dn, _ = ellipj(frequency * t, parameter)
    return Known(t, stack(A * cn), stack(-A * frequency * sn * dn))


def make_hardening() -> tuple[sr.System, Any]:
    body = cart(1.0, position=(0.2, 0, 0))
    law = sr.TSDA(
        "spring",
        sr.ground.point(-1, 0, 0),
        body.point(0, 0, 0),
        k=lambda l: 10.0 + 4000.0 * (l - 1.0) ** 2,
        length=1.0,
    )
    return slide(1.0, law, body=body), None


def hanging(t: Array) -> Known:
    """A mass that is dropped from where its springs have no tension, in three coordinates: only z moves."""
    g, k, mass = 9.81, 500.0, 2.0
    frequency = np.sqrt(k / mass)
    drop = mass * g / k
    return Known(
        t, stack(-drop * (1 - np.cos(frequency * t))), stack(-drop * frequency * np.sin(frequency * t))
    )


def make_hanging() -> tuple[sr.System, Any]:
    body = cart(2.0)
    spring = sr.TSDA("spring", sr.ground.point(0, 0, 1), body.point(0, 0, 0), k=500.0, length=1.0)
    return sr.System(sr.Model("hanging", [body], [], [spring], gravity=(0, 0, -9.81))), None


def bushing(t: Array) -> Known:
    """A rigid body on a bushing, displaced along x and z: two frequencies."""
    w = np.sqrt(np.array([2e5, 8e5]) / 5.0)
    start = np.array([1e-3, 2e-3])
    return Known(t, start * np.cos(np.outer(t, w)), -start * w * np.sin(np.outer(t, w)))


def make_bushing() -> tuple[sr.System, Any]:
    body = cart(5.0)
    mount = sr.Bushing("mount", sr.ground, body, point=(0, 0, 0), stiffness=(2e5, 3e5, 8e5, 1e3, 1e3, 1e3))
    system = sr.System(sr.Model("mount", [body], [], [mount]))
    q = system.q0.copy()
    q[[0, 2]] = 1e-3, 2e-3
    return system, sr.assemble(system, q)


OSCILLATORS = (
    oscillator("spring, 20 s", 1.0, 40.0, 0.2, 20.0),
    oscillator("spring, 10 krad/s", 1.0, 1e8, 0.01, 0.01),
    oscillator("spring, 3 um", 1.0, 40.0, 3e-6, 20.0),
    oscillator("spring, 1 nm", 1e-12, 1e-3, 1e-9, 1e-3),
    oscillator("spring, 1 km", 1e6, 100.0, 1e3, 2000.0),
    oscillator("spring, 0.01 rad/s", 1.0, 1e-4, 0.2, 2000.0),
    oscillator("spring, stiff and undamped", 1.0, 1e8, 0.01, 0.1),
    oscillator("spring, light", 1e-6, 1.0, 0.05, 0.1),
    oscillator("spring, damped", 1.0, 100.0, 0.1, 5.0, c=2.0),
    oscillator("spring, overdamped", 1.0, 100.0, 0.1, 5.0, c=1000.0),
    oscillator("spring, thrown", 2.0, 50.0, 1e-9, 10.0, c=0.5, speed=3.0),
    oscillator("spring, 10 000 periods", 1.0, 40.0, 0.1, 9935.3),
    two_masses("two masses", (1.0, 2.0), (100.0, 50.0), 10.0),
    two_masses("two masses, one stiff", (1.0, 1.0), (100.0, 1e6), 2.0),
    two_masses("two masses, one light", (1.0, 1e-6), (100.0, 1.0), 2.0),
    Problem("hardening spring", make_hardening, 5.0, hardening, READ),
    Problem(
        "hanging mass",
        make_hanging,
        5.0,
        hanging,
        motion("mass.z"),
    ),
    Problem(
        "bushing",
        make_bushing,
        0.1,
        bushing,
        motion("mass.x", "mass.z"),
    ),
)
