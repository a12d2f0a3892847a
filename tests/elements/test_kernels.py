"""Every kernel of every registered element against an independent value.

Polynomial kernels are held against five-point differences in fractions, which are exact: the comparison is `==`. The
others (a root, an angle) are held against differences in 70 digits.
"""

import numpy as np
import pytest
from tests.elements import definitions
from tests.elements.checks import (
    all_checks,
    at_depth,
    derivative_at,
    derivative_of_an_operator,
    euler_functions,
)
from tests.elements.own import OWN
from tests.elements.states import COMPLEX, DIGITS, WHOLE, computes_polynomials, is_polynomial, state, written

from sarrus.elements import (
    BUILT_IN,
    OPERATORS,
    Dot1,
    Element,
    ElementError,
    Force,
    InertiaElement,
    Primitive,
    RigidInertia,
)
from sarrus.elements.element import Scalar
from sarrus.elements.operators import DERIVATIVES


def label(check):
    return f"{check.kind.__name__ if check.kind else 'functions'}-{check.name}"


@pytest.mark.parametrize("check", all_checks(quick=False), ids=label)
def test_kernel(check):
    check.run()


@pytest.mark.one_in(8)
@pytest.mark.parametrize("seed", range(1, 5))
@pytest.mark.parametrize("kind", [*BUILT_IN, *OWN], ids=lambda kind: kind.__name__)
def test_derivatives_at_more_states(kind, seed):
    """The same in whole numbers, exact too, or by a complex step."""
    for operator in kind.family:
        if operator.name in DERIVATIVES:
            derivative_of_an_operator(kind, operator.name, WHOLE if is_polynomial(kind) else COMPLEX, seed)


@pytest.mark.parametrize("seed", range(10, 13))
def test_euler_functions_at_more_states(seed):
    euler_functions(seed)


def test_every_element_has_a_definition():
    """A new element without an independent definition is noticed here."""
    tables = {
        Primitive: definitions.CONSTRAINTS,
        InertiaElement: {**definitions.INERTIAS, **definitions.JOINT_INERTIAS},
        Force: definitions.FORCES,
    }
    for family, table in tables.items():
        assert set(table) == {kind for kind in BUILT_IN if issubclass(kind, family)}


def test_which_elements_are_polynomial():
    """All others have a root, an angle or a function in them; a division that sneaks in elsewhere is noticed here."""
    rooted = "TSDA NonlinearTSDA RSDA NonlinearRSDA LengthStop DisplacementStop AngleStop SphereContact Drag"
    curved = "VaryingForce VaryingFollowerForce VaryingTorque VaryingBodyTorque RoadTyre SurfaceTyre"
    other = "AngleFriction DisplacementFriction Bushing AngleInertia DisplacementInertia"
    joints = "Heading Angle AngleAngle DisplacementAngle Screw AngleDriver"
    joints += " DisplacementDriver DistanceDriver CoordinateDriver"
    expected = {*rooted.split(), *curved.split(), *other.split(), *joints.split()}
    assert {kind.__name__ for kind in BUILT_IN if not computes_polynomials(kind, written(kind))} == expected
    assert {kind.__name__ for kind in BUILT_IN if not is_polynomial(kind)} == expected


@pytest.mark.parametrize("depth", ["apart", "rounded off", "rounded on", "deep"])
@pytest.mark.parametrize("kind", definitions.DEPTHS, ids=lambda kind: kind.__name__)
def test_contacts_at_every_depth(kind, depth):
    """Kernels and derivatives of contacts apart, on both sides of the rounding, and in full contact."""
    there = at_depth(
        state(kind, COMPLEX), {"apart": -0.7, "rounded off": -0.3, "rounded on": 0.2, "deep": 1.5}[depth]
    )
    assert np.any(there("Q")) == (depth != "apart")
    for operator in kind.family:
        if operator.name in DERIVATIVES:
            derivative_at(there, operator.name)


@pytest.mark.parametrize("kind", [kind for kind in OWN if kind.timed], ids=lambda kind: kind.__name__)
def test_terms_in_time_are_not_zero(kind):
    """So that the checks above compare more than zeros."""
    here = state(kind, DIGITS)
    for name in ("Phi_t", "Phi_tt", "Phi_q_xi_t", "Phi_t_b", "gamma_q", "gamma_v", "gamma_b"):
        assert name in OPERATORS
        assert abs(here(name)).max() > 0, name


def test_a_subclass_with_other_fields_has_parameter_derivatives_of_its_own():
    """Those that are written for the fields of its base would have too few blocks."""

    class Shifted(Dot1, rows=1, derivatives="automatic", registered=False):
        shift: Scalar

        def Phi(self, x):
            return super().Phi(x) - self.shift * self.shift

    assert Shifted.Phi_q is Dot1.Phi_q
    for name in ("Phi_b", "Phi_q_xi_b", "Phi_q_xi_q_eta_b", "Phi_qT_lam_b"):
        derivative_of_an_operator(Shifted, name, WHOLE)
    with pytest.raises(ElementError, match="M_a_b is missing"):

        class Coded(RigidInertia, registered=False):
            shift: Scalar

    with pytest.raises(ElementError, match="M_a_b is missing"):

        class Constant(RigidInertia, registered=False):
            M_a_b = 3


def test_a_subclass_inherits_derived_kernels():
    class Stronger(OWN[3], bodies=4, registered=False):
        more: Scalar

    derivative_of_an_operator(Stronger, "Q_b", WHOLE)


def test_elements_of_the_tests_are_not_registered():
    assert set(Element.registry.values()).isdisjoint(OWN)
