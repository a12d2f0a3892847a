"""Jansen's legs on one crank, in a row: a planar mechanism with three loops for each leg, and its equation by hand."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import sarrus as sr

Pair = NDArray[np.complex128]
A, B, C, D, E, F, G, H, I, J, K, L, M = (
    x / 100 for x in (38.0, 41.5, 39.3, 40.1, 55.8, 39.4, 36.7, 65.7, 49.0, 50.0, 61.9, 7.8, 15.0)
)
Z, GRAVITY, DENSITY = (0.0, 0.0, 1.0), 9.81, 2.0  # kg per metre of a rod


def corner(p: Pair, q: Pair, from_p: float, from_q: float) -> Pair:
    """The point at distances from p and q, on the left of the way from p to q."""
    d = q - p
    square = d @ d
    along = (from_p**2 - from_q**2 + square) / (2 * square)
    across = np.sqrt(from_p**2 / square - along**2)
    return p + along * d + across * np.array([-d[1], d[0]])


def points(angle: complex, phase: float, side: float) -> dict[str, Pair]:
    """All pins of a leg; `side` -1 mirrors it."""
    turned = side * (angle + phase)
    crank = M * np.array([np.cos(turned), np.sin(turned)])
    pivot = np.array([-A, -L], dtype=complex)
    top = corner(pivot, crank, B, J)
    low = corner(crank, pivot, K, C)
    left = corner(pivot, top, D, E)
    knee = corner(low, left, G, F)
    foot = corner(low, knee, I, H)
    mirror = np.array([side, 1.0])
    named = {"crank": crank, "pivot": pivot, "top": top, "low": low, "left": left, "knee": knee, "foot": foot}
    return {name: mirror * at for name, at in named.items()}


RODS = {  # every body by its pins; the first is the origin of its mass with the second and third
    "j": ("crank", "top"),
    "k": ("crank", "low"),
    "upper": ("pivot", "top", "left"),
    "c": ("pivot", "low"),
    "f": ("left", "knee"),
    "lower": ("low", "knee", "foot"),
}
PINS = {  # joint: body i, body j, pin
    "crank_j": ("wheel", "j", "crank"),
    "crank_k": ("wheel", "k", "crank"),
    "top": ("j", "upper", "top"),
    "hip": ("ground", "upper", "pivot"),
    "heel": ("ground", "c", "pivot"),
    "low_c": ("k", "c", "low"),
    "low_foot": ("k", "lower", "low"),
    "left": ("upper", "f", "left"),
    "knee": ("f", "lower", "knee"),
}


class Walker:
    """Legs on one crank at equal phases, every other one mirrored."""

    def __init__(self, legs: int, start: float = 0.3, driver: str = "") -> None:
        self.start = start
        self.legs = [(2 * np.pi * n / legs, 1.0 - 2 * (n % 2)) for n in range(legs)]
        wheel = sr.Body("wheel", 3.0, (0.1, 0.1, 0.1))
        bodies, joints = [wheel], [sr.Revolute("axle", sr.ground, wheel, point=(0, 0, 0), axis=Z)]
        for n, leg in enumerate(self.legs):
            pins = {name: (*at.real, 0.1 * n) for name, at in points(start, *leg).items()}
            solids: dict[str, sr.Body] = {}
            for name, own in RODS.items():
                mass, inertia = properties(own, points(start, *leg))
                middle = np.mean([pins[pin] for pin in own], axis=0)
                solids[name] = sr.Body(f"{name}_{n}", mass, (inertia,) * 3, position=tuple(middle))
            every = {"ground": sr.ground, "wheel": wheel, **solids}
            for name, (i, j, pin) in PINS.items():
                joints.append(sr.Revolute(f"{name}_{n}", every[i], every[j], point=pins[pin], axis=Z))
            bodies += solids.values()
        drivers = [sr.AngleDriver("motor", "axle", driver)] if driver else []
        model = sr.Model("walker", bodies, joints, gravity=(0, -GRAVITY, 0), drivers=drivers)
        self.system = sr.System(model)

    def energies(self, angle: complex) -> tuple[float, complex]:
        """Twice the kinetic energy for a rate of 1 rad/s, and the potential energy, which may be complex."""
        inertia, potential, step = 0.1, 0.0j, 1e-20
        for leg in self.legs:
            here, ahead = points(angle, *leg), points(np.real(angle) + 1j * step, *leg)
            for own in RODS.values():
                mass, moment = properties(own, points(self.start, *leg))
                rate = {pin: ahead[pin].imag / step for pin in own}
                along = (ahead[own[1]] - ahead[own[0]]).real
                turning = (
                    along[0] * (rate[own[1]] - rate[own[0]])[1] - along[1] * (rate[own[1]] - rate[own[0]])[0]
                )
                middle = np.mean([rate[pin] for pin in own], axis=0)
                inertia += mass * middle @ middle + moment * (turning / (along @ along)) ** 2
                potential += mass * GRAVITY * np.mean([here[pin][1] for pin in own])
        return float(inertia), potential

    def slope(self, angle: float) -> float:
        """The torque of the weight against the crank, by a complex step."""
        return float(self.energies(angle + 1e-20j)[1].imag / 1e-20)


def properties(own: tuple[str, ...], at: dict[str, Pair]) -> tuple[float, float]:
    """Mass of a body, and the moment of inertia of equal points at its pins."""
    places = np.array([at[pin].real for pin in own])
    mass = DENSITY * float(np.linalg.norm(places[1] - places[0]))
    return mass, mass * float(np.mean(np.sum((places - places.mean(axis=0)) ** 2, axis=1)))
