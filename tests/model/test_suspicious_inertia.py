"""Warnings about inertia: of other units, not of bodies whose points are near each other, nor where it is not used."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

import sarrus as sr
from sarrus.elements import InertiaElement
from sarrus.elements.element import Grid, Row, Scalar, Single
from sarrus.model.geometry.pose import Poses
from sarrus.model.primitive import Primitive

Z = (0, 0, 1)


def test_a_flywheel_that_is_hinged_beside_its_centre_of_mass() -> None:
    wheel = sr.Body.cylinder("wheel", radius=0.14, length=0.03, axis="z", mass=2.0, position=(1e-3, 0, 0))
    axle = sr.Revolute("axle", sr.ground, wheel, point=(0, 0, 0), axis=Z)
    assert not sr.System(sr.Model("rotor", [wheel], [axle])).warnings


def test_a_carrier_that_cannot_turn_and_a_point_mass() -> None:
    carrier = sr.Body("carrier", 0.1, (1.0, 1.0, 1.0), position=(0, 0, 0))
    point = sr.Body("point", 0.1, (1.0, 1.0, 1.0), position=(0.01, 0, 0))
    rail = sr.Translational("rail", sr.ground, carrier, point=(0, 0, 0), axis=(1, 0, 0))
    string = sr.TSDA("string", carrier.point(0, 0, 0), point.point(0, 0, 0), k=10.0, length=0.01)
    assert not sr.System(sr.Model("carriage", [carrier, point], [rail], [string])).warnings


def test_inertia_in_kg_mm2() -> None:
    arm = sr.Body("arm", 2.0, (1e4, 2e5, 2e5), position=(0.5, 0, 0))
    pin = sr.Revolute("pin", sr.ground, arm, point=(0, 0, 0), axis=Z)
    with pytest.warns(sr.SarrusWarning, match="arm: its radius of gyration is 316.2 m .* in kg m²"):
        sr.System(sr.Model("arm", [arm], [pin]))


class AddedMass(InertiaElement, derivatives="automatic", rare=True, registered=False):
    """A mass without moments, as of water around a body."""

    mass: Scalar  # [kg]

    def M(self, x: Single) -> Grid:
        return ((self.mass * np.eye(3), None), (None, None))

    def M_a(self, x: Single, a: Single) -> Row:
        return self.mass * a.r, None

    def S(self, x: Single, v: Single) -> Row:
        return 0 * v.r, 0 * v.p


@dataclass(frozen=True, eq=False)
class Water(sr.model.Force):
    """It adds mass to a body."""

    body: sr.Body

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        yield Primitive(AddedMass, (self.body.name,), (3.0,), "inertia")


del sr.model.Force.kinds["water"]  # other tests see those of the package alone


def test_an_element_of_inertia_with_a_field_of_the_same_name() -> None:
    ball = sr.Body("ball", 2.0, (0.1, 0.1, 0.1))
    system = sr.System(sr.Model("float", [ball], [], [Water("water", ball)], gravity=(0, 0, -10.0)))
    assert system.M(system.q0).toarray()[0, 0] == 5.0
