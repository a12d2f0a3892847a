"""The derivative check: it passes what is right and names what is wrong, in a user's own element too."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest
from tests.system.mechanisms import hmmwv, slider_crank

import sarrus as sr
from sarrus.algebra import Array, Row, row
from sarrus.elements import Dot1, Element
from sarrus.elements.element import Pair
from sarrus.model import Joint
from sarrus.model.geometry.placement import AboutAxis
from sarrus.model.geometry.pose import Poses
from sarrus.model.primitive import Primitive


@pytest.mark.one_in(4)
@pytest.mark.parametrize("system", [slider_crank, hmmwv])
@pytest.mark.parametrize("seed", [0, 1])
def test_shipped_mechanisms_agree(system: object, seed: int) -> None:
    report = system().check_derivatives(seed=seed)  # type: ignore[operator]
    assert report, str(report)
    assert max(finding.error for finding in report.findings) < 1e-11


class Tilted(Dot1, rows=1):
    """DOT-1 with a wrong sign in one block of its Jacobian, as a user might write it."""

    def Phi_q(self, x: Pair) -> Row:
        by_r_i, by_p_i, by_r_j, by_p_j = super().Phi_q(x)
        assert by_p_j is not None
        return by_r_i, by_p_i, by_r_j, -by_p_j


class Leaning(Dot1, rows=1):
    """The same constraint, right: a_i·a_j with its own name."""

    def Phi(self, x: Pair) -> Array:
        return row(super().Phi(x))[0]


def model_with(element: type[Element]) -> sr.Model:
    @dataclass(frozen=True, eq=False)
    class Own(AboutAxis, Joint):
        def primitives(self, poses: Poses) -> Iterator[Primitive]:
            i, j = self.frames(poses)
            yield Primitive(element, (i.body, j.body), (tuple(i.f), tuple(j.h)), "f_i.h_j")

    Joint.kinds.pop("own")
    a = sr.Body("a", mass=1.0, inertia=(1, 1, 1))
    b = sr.Body("b", mass=1.0, inertia=(1, 2, 2), position=(1, 0, 0))
    return sr.Model("two", bodies=[a, b], joints=[Own("hinge", a, b, point=(0, 0, 0), axis=(0, 0, 1))])


def test_wrong_block_is_named() -> None:
    report = sr.System(model_with(Tilted)).check_derivatives()
    assert not report
    wrong = next(f for f in report.findings if f.operator.name == "Phi_q")
    assert wrong.where.startswith("hinge: f_i.h_j, b.p.e")
    assert "WRONG at hinge" in str(report)


def test_users_element_is_compiled_and_right() -> None:
    system = sr.System(model_with(Leaning))
    assert system.check_derivatives()
    assert np.allclose(system.Phi(system.q0), 0)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("system", [slider_crank, hmmwv])
def test_residuals_that_cancel_are_no_error(system: object) -> None:
    made = system()  # type: ignore[operator]
    assert made.check_derivatives(made.q0)


@pytest.mark.slow
@pytest.mark.parametrize(("creep", "radius"), [(1e-3, 0.01), (2e-3, 0.01), (5e-3, 0.1)])
def test_friction_far_from_its_reversal_agrees(creep: float, radius: float) -> None:
    """Terms cancel in single rows there; the check took their round-off for an error of a shipped element."""
    a = sr.Body("a", mass=1.0, inertia=(1, 1, 1))
    b = sr.Body("b", mass=1.0, inertia=(1, 1, 1), position=(0, 0, 1))
    about = {"body_i": a, "body_j": b, "point": (0, 0, 0), "axis": (0, 0, 1)}
    rub = sr.AngleFriction("pin", radius=radius, load=5.0, mu=0.2, creep=creep, **about)
    system = sr.System(sr.Model("rubbed", [a, b], [], [rub]))
    for seed in range(5):
        report = system.check_derivatives(seed=seed)
        assert report, str(report)


def test_powers_of_zero_have_no_wrong_derivatives() -> None:
    """In plain NumPy, the force of 1e-133 N loses its complex step by underflow; its derivatives were called wrong."""
    body = sr.Body("m", 1.0, (0.1, 0.1, 0.1))
    law = "-200*max(0, m.x - 0.5)^1.5*(1 + 0.3*m.velocity.x)"
    contact = sr.PointForce("contact", body.point(0, 0, 0), (law, 0, 0))
    report = sr.System(sr.Model("contact", [body], forces=[contact])).check_derivatives()
    assert report, report
