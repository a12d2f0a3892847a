"""Runs of all kinds take a body through a contact without a loss as closed forms do: flights, pushes and falls."""

from itertools import product
from typing import Any, NamedTuple

import numpy as np
import pytest

import sarrus as sr

KINDS: dict[str, dict[str, Any]] = {
    "plain": {},
    "stored": {"store": "steps"},
    "dense": {"store": "dense"},
}
PUSH = {"coasting": 0.0, "pushed": 1.0, "falling": 9.81}


class Flight(NamedTuple):
    """A body that moves along x, or down, towards a contact with a stiffness, under a constant force."""

    contact: str
    stiffness: float
    rounding: float
    distance: float
    motion: str
    mass: float = 1.0
    speed: float = 2.0

    @property
    def acceleration(self) -> float:
        return PUSH[self.motion] / (self.mass if self.motion == "pushed" else 1.0)

    @property
    def until(self) -> float:
        """Half of the time of the flight after the contact."""
        v, a, x = self.begin, self.acceleration, self.distance
        return float(1.5 * 2 * x / (v + np.sqrt(v * v + 2 * a * x)))

    @property
    def begin(self) -> float:
        return self.speed if self.motion == "coasting" else 0.0

    @property
    def way(self) -> np.ndarray:
        return np.array((0.0, 0.0, -1.0) if self.contact == "tyre" else (1.0, 0.0, 0.0))

    def system(self) -> sr.System:
        ground, axis = sr.ground, {"point": (0, 0, 0), "axis": self.way}
        body = sr.Body("b", self.mass, (0.1,) * 3, velocity=self.begin * self.way)
        joint = sr.Translational("j", ground, body, **axis)
        law, end = {"stiffness": self.stiffness, "rounding": self.rounding}, self.distance
        wall = ground.frame((end, 0, 0), z=(-1, 0, 0))
        force: Any = {
            "stop": lambda: sr.DisplacementStop("c", ground, body, **axis, upper=end, **law),
            "sphere": lambda: sr.SphereContact("c", body.point(0, 0, 0), wall, **law),
            "length": lambda: sr.LengthStop(
                "c", ground.point(-1, 0, 0), body.point(0, 0, 0), upper=1 + end, **law
            ),
            "tyre": lambda: sr.RoadTyre(
                "c",
                body.point(0, 0, 0),
                k=self.stiffness,
                c=0.0,
                radius=0.3,
                road=-0.3 - end,
                rounding=self.rounding,
            ),
            "formula": lambda: sr.Force("c", joint="j", value=f"-{self.stiffness}*max(x-{end},0)"),
        }[self.contact]()
        joints, forces = [joint], [force]
        if self.motion == "pushed":
            forces.append(sr.Force("push", joint="j", value=PUSH["pushed"]))
        gravity = (9.81 if self.motion == "falling" else 0.0) * self.way
        return sr.System(sr.Model("flight", [body], joints, forces, gravity=gravity))

    def state(self) -> tuple[float, float]:
        """The place and speed at the end: those of a flight back, later by the contact of a linear spring."""
        v, a, x = self.begin, self.acceleration, self.distance
        fast, frequency = np.sqrt(v * v + 2 * a * x), np.sqrt(self.stiffness / self.mass)
        lasts = (np.pi + 2 * np.arctan(a / frequency / fast)) / frequency
        back = self.until - 2 * x / (v + fast) - lasts
        return float(x - fast * back + a * back**2 / 2), float(-fast + a * back)


FLIGHTS = [
    Flight("stop", 1e9, 1e-6, 20.0, "coasting"),
    Flight("stop", 1e9, 1e-4, 20.0, "coasting", speed=0.5),
    Flight("sphere", 1e8, 1e-6, 20.0, "coasting"),
    Flight("sphere", 1e6, 1e-6, 50.0, "coasting"),
    Flight("stop", 1e9, 1e-6, 50.0, "pushed", 10.0),
    Flight("stop", 1e9, 1e-6, 50.0, "pushed", 1000.0),
    Flight("length", 1e8, 1e-6, 5.0, "falling"),
    Flight("formula", 1e9, 0.0, 20.0, "coasting"),
    Flight("tyre", 1e7, 1e-4, 20.0, "falling"),
    Flight("tyre", 1e9, 1e-6, 20.0, "coasting"),
]  # fmt: skip
OTHERS = [
    Flight(contact, stiffness, 0.0 if contact == "formula" else rounding, distance, motion, 1.0, speed)
    for contact, stiffness, rounding, distance, motion, speed in product(
        ("stop", "sphere", "length", "formula", "tyre"),
        (1e5, 1e7, 1e9),
        (1e-3, 1e-6),
        (1.0, 20.0),
        PUSH,
        (0.5, 5.0),
    )
    if (contact != "formula" or rounding == 1e-6) and (motion == "coasting" or speed == 0.5)
]


def check(flight: Flight, **options: Any) -> None:
    run = sr.simulate(flight.system(), until=flight.until, t_eval=[0, flight.until], **options)
    place, speed = flight.state()
    fast = np.sqrt(flight.begin**2 + 2 * flight.acceleration * flight.distance)
    # A rounding makes the contact as long as a flight over some of its widths
    late = 4 * flight.rounding / fast + 1e-6 * flight.until
    assert run.success
    assert not run.warnings
    assert run.v[-1, :3] @ flight.way == pytest.approx(speed, abs=late * flight.acceleration + 1e-5 * fast), (
        flight
    )
    assert run.q[-1, :3] @ flight.way == pytest.approx(place, abs=late * fast + 1e-5 * flight.distance), (
        flight
    )


@pytest.mark.parametrize("kind", KINDS)
def test_a_body_comes_back_with_its_speed(kind: str) -> None:
    for flight in FLIGHTS:
        check(flight, **KINDS[kind])


@pytest.mark.one_in(40)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("flight", OTHERS, ids=lambda flight: "-".join(str(x) for x in flight))
def test_it_does_so_from_everywhere(flight: Flight, kind: str) -> None:
    check(flight, **KINDS[kind])
