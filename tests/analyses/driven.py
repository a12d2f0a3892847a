"""Driven mechanisms with known motions, for several tests."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

import sarrus as sr
from sarrus import mechanisms

X0 = 4.172214269048909  # the slider's start


def driven_slider_crank(driver: sr.AngleDriver | sr.DisplacementDriver) -> sr.System:
    model = sr.load(mechanisms.path("slider_crank"))
    return sr.System(replace(model, drivers=[driver]))


@cache
def turned(rate: float, growth: float) -> sr.System:
    """The crank is at 0.5 + rate t + ½ growth t²."""
    return driven_slider_crank(sr.AngleDriver("motor", "pin", f"{rate}*t + {growth / 2}*t**2"))


@cache
def pushed(rate: float) -> sr.System:
    """The slider is at X0 + rate t."""
    return driven_slider_crank(sr.DisplacementDriver("push", "guide", f"{rate}*t"))


class SliderOfCrank:
    """x = √(25 - y² - z²) with the pin at y = 1 - 2 sin θ, z = 1 + 2 cos θ, and its derivatives in time."""

    def __init__(self, t: np.ndarray, rate: float, growth: float) -> None:
        th, w = 0.5 + rate * t + growth * t * t / 2, rate + growth * t
        s = 25 - (1 - 2 * np.sin(th)) ** 2 - (1 + 2 * np.cos(th)) ** 2  # = 19 + 4 sin θ - 4 cos θ
        s1, s2 = 4 * np.cos(th) + 4 * np.sin(th), -4 * np.sin(th) + 4 * np.cos(th)
        self.x = np.sqrt(s)
        self.v = s1 * w / (2 * self.x)
        self.a = (s2 * w * w + s1 * growth) / (2 * self.x) - self.v**2 / self.x


def planar_body(name: str, r: tuple[float, float], *, inertia: float = 0.1, mass: float = 1.0) -> sr.Body:
    return sr.Body(name, mass=mass, inertia=(inertia, inertia, inertia), position=(*r, 0.0))


@cache
def parallelogram(rate: float = 1.0) -> sr.System:
    """Sides 1 and 2, hinged by four revolutes, three equations too many; the crank's angle is 1 + rate t."""
    crank = planar_body("crank", (np.cos(1.0), np.sin(1.0)))
    coupler = planar_body("coupler", (np.cos(1.0) + 1.0, np.sin(1.0)))
    rocker = planar_body("rocker", (np.cos(1.0) + 2.0, np.sin(1.0)))
    z, pins = (0, 0, 1), {"A": (0, 0, 0), "B": (np.cos(1.0), np.sin(1.0), 0), "D": (2, 0, 0)}
    pins["C"] = (pins["B"][0] + 2, pins["B"][1], 0)
    pairs = {"A": (sr.ground, crank), "B": (crank, coupler), "C": (coupler, rocker), "D": (sr.ground, rocker)}
    joints = [sr.Revolute(name, *pairs[name], point=pins[name], axis=z) for name in "ABCD"]
    motor = sr.AngleDriver("motor", "A", f"{rate}*t")
    return sr.System(sr.Model("parallelogram", [crank, coupler, rocker], joints, drivers=[motor]))


@cache
def six_bar() -> sr.System:
    """A four-bar OABC with a second pair of links DE, EF on its rocker, six equations too many."""
    places = {
        "O": (0, 0),
        "A": (0.2, 0.25),
        "B": (1, 1),
        "C": (1.2, 0),
        "D": (1.3, 0.9),
        "E": (2.4, 1.5),
        "F": (2.5, 0),
    }
    ends = {"crank": "OA", "coupler": "AB", "rocker": "CB", "rod": "DE", "output": "FE"}
    links = {
        name: planar_body(name, tuple(np.mean([places[a], places[b]], axis=0)))
        for name, (a, b) in ends.items()
    }
    pairs = {
        "A": ("crank", "coupler"),
        "B": ("coupler", "rocker"),
        "D": ("rocker", "rod"),
        "E": ("rod", "output"),
    }
    on_ground = {"O": "crank", "C": "rocker", "F": "output"}
    both = {name: (sr.ground, links[link]) for name, link in on_ground.items()}
    both |= {name: (links[one], links[other]) for name, (one, other) in pairs.items()}
    joints = [sr.Revolute(name, *both[name], point=(*at, 0.0), axis=(0, 0, 1)) for name, at in places.items()]
    motor, bodies = sr.AngleDriver("motor", "O", "6*t"), list(links.values())
    return sr.System(sr.Model("six-bar", bodies, joints, gravity=(0, -9.81, 0), drivers=[motor]))


G, L, MASS, J = 9.81, 0.7, 1.3, 0.05


def pendulum(*motions: str, angle: float = 0.0) -> sr.System:
    """Pin at the origin about z, centre of mass L below at angle 0; gravity along -y. Motions are those of drivers."""
    place = (L * np.sin(angle), -L * np.cos(angle), 0.0)
    turn = sr.AxisAngle((0, 0, 1), angle)
    bob = sr.Body("bob", mass=MASS, inertia=(J, J, J), position=place, orientation=turn)
    pin = sr.Revolute("pin", sr.ground, bob, point=(0, 0, 0), axis=(0, 0, 1))
    drivers = [sr.AngleDriver(f"motor_{n}", "pin", motion) for n, motion in enumerate(motions)]
    return sr.System(sr.Model("pendulum", [bob], [pin], gravity=(0, -G, 0), drivers=drivers))
