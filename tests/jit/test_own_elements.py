"""Elements written in a user's script: compiled as they stand, checked as ours, and refused in words if incomplete."""

import numpy as np
import pytest
from tests.jit.mixed import by_hand, mixed_system, part_of, random_state

from sarrus._jit.formulas.expression import Graph
from sarrus._jit.formulas.functions import atan2, nearest, sqrt
from sarrus.algebra import I3, outer, row, single
from sarrus.elements import OPERATORS, Element, ElementError
from sarrus.elements import Force as ForceElement
from sarrus.elements import Primitive as Constraint
from sarrus.elements.element import Curve, Memory, Scalar, Vec3
from sarrus.elements.evaluation import element_from, grid
from sarrus.model import Force, Joint, ModelError

pytestmark = pytest.mark.usefixtures("own_classes")


def plane():
    """A constraint of one's own: the body's origin stays on a paraboloid, nᵀr + k rᵀr = height."""

    class Paraboloid(Constraint, rows=1, bodies=1):
        n: Vec3
        k: Scalar
        height: Scalar

        def Phi(self, x):
            return row(self.n) @ x.r + self.k * (row(x.r) @ x.r) - self.height

        def Phi_q(self, x):
            return row(self.n + 2 * self.k * x.r), None

        def Phi_q_xi_q(self, x, xi):
            return row(2 * self.k * xi.r), None

        def Phi_q_xi_q_eta_q(self, x, xi, eta):
            return None, None

        def Phi_qT_lam_q(self, x, lam):
            return (2 * self.k * lam[0] * I3, None), (None, None)

        def Phi_qT_lam_q_xi_q(self, x, lam, xi):
            return (None, None), (None, None)

        def Phi_b(self, x):
            return row(x.r), single(x.r @ x.r), single(-1)

        def Phi_q_xi_b(self, x, xi):
            return row(xi.r), single(2 * (x.r @ xi.r)), None

        def Phi_q_xi_q_eta_b(self, x, xi, eta):
            return None, single(2 * (xi.r @ eta.r)), None

        def Phi_qT_lam_b(self, x, lam):
            return (lam[0] * I3, (2 * lam[0] * x.r)[:, None], None), (None, None, None)

    return Paraboloid


def strange_force(wrong=0):
    """A force of one's own with every function that kernels may call; `wrong` spoils one derivative."""

    class Strange(ForceElement, bodies=2):
        k: Scalar
        profile: Curve

        def _size(self, x, t):
            a, b = x.r_i @ x.r_i + 1, x.r_j[0] * x.r_j[0] + 2
            turns = nearest(x.r_i[0] + x.r_j[1])
            return self.k * sqrt(a) * b + atan2(x.r_j[2], a) + turns + self.profile(a) * t + a / b

        def Q(self, x, v, t):
            return self._size(x, t) * v.r_i, None, None, None

        def Q_q(self, x, v, t):
            a, b, u = x.r_i @ x.r_i + 1, x.r_j[0] * x.r_j[0] + 2, x.r_j[2]
            rho = a * a + u * u
            by_a = self.k * b / (2 * sqrt(a)) - u / rho + self.profile.slope(a) * t + 1 / b
            by_b = self.k * sqrt(a) - a / (b * b) + wrong
            by_r_j = np.array([2 * x.r_j[0] * by_b, 0 * u, a / rho])
            none = (None,) * 4
            return (outer(v.r_i, 2 * by_a * x.r_i), None, outer(v.r_i, by_r_j), None), none, none, none

        def Q_v(self, x, v, t):
            none = (None,) * 4
            return (self._size(x, t) * I3, None, None, None), none, none, none

        def Q_b(self, x, v, t):
            a, b = x.r_i @ x.r_i + 1, x.r_j[0] * x.r_j[0] + 2
            return ((sqrt(a) * b * v.r_i)[:, None], None), (None, None), (None, None), (None, None)

    return Strange


@pytest.fixture(scope="module")
def system(own_classes):
    return mixed_system(part_of(Joint), part_of(Force), names=("a", "b"), kinds=(plane(), strange_force()))


def test_they_join_the_system(system):
    assert system.counts()["Paraboloid"] == 2
    assert system.counts()["Strange"] == 4
    assert system.m == 2 + 2


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    "name", [op.name for op in OPERATORS.values() if op.family in ("constraint", "force")]
)
def test_their_operators_are_compiled(system, name):
    state, operator = random_state(system), OPERATORS[name]
    found = getattr(system, name)(**{key: state[key] for key in ("q", *operator.operands)})
    expected = by_hand(system, operator, state)
    found = found if isinstance(found, np.ndarray) else found.toarray()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * (1 + abs(expected).max()))


@pytest.mark.slow
def test_their_derivatives_are_checked_as_ours(system):
    report = system.check_derivatives()
    assert report, str(report)


@pytest.mark.slow
def test_a_wrong_derivative_is_found_and_named(own_classes):
    spoilt = mixed_system(part_of(Joint), part_of(Force), names=("a", "b"), kinds=(strange_force(wrong=0.5),))
    report = spoilt.check_derivatives()
    wrong = [f.operator.name for f in report.findings if not f.ok]
    assert wrong == [
        "Q_q",
        "Q_q_xi_v",
        "Q_v_xi_q",
    ]  # each of these two is the derivative of the other's operator
    assert "WRONG at" in str(report)


# ------------------------------------------------------------------------------------------------- refusals


def test_missing_kernels_are_named():
    with pytest.raises(ElementError, match=r"element Half: Q_q, Q_b is missing\. Write one method for each"):

        class Half(ForceElement, bodies=1):
            def Q(self, x, v, t):
                return None, None

            def Q_v(self, x, v, t):
                return None, None

    assert "Half" not in Element.registry


def test_what_follows_need_not_be_written():
    kind = plane()
    for operator in kind.family:
        assert callable(getattr(kind, operator.name))
    assert not any(op.name in vars(Constraint) for op in kind.family)


@pytest.mark.parametrize("annotation", [float, "float", "Vec4", np.ndarray])
def test_a_wrong_annotation_is_named(annotation):
    body = {"__annotations__": {"stiffness": annotation}}
    with pytest.raises(
        ElementError,
        match=r"element Odd: stiffness is annotated with .*Choose from Vec3, Inertia, Scalar, Curve",
    ):
        type("Odd", (ForceElement,), body)


@pytest.mark.parametrize("test", ["if x.r[0] > 0", "if x.r[0]", "if not x.r @ x.r", "if x.r[0] == 0"])
def test_a_kernel_that_branches_is_refused(test):
    namespace = {}
    exec(f"def Q(self, x, v, t):\n    {test}:\n        return x.r, None\n    return None, None", namespace)
    zero = (None, None), (None, None)
    others = {name: lambda self, x, v, t: zero for name in ("Q_q", "Q_v", "Q_b")}
    kind = type(ForceElement)("Branching", (ForceElement,), {"Q": namespace["Q"], **others}, bodies=1)
    graph = Graph()
    operands = {name: graph.inputs(name, 7) for name in ("q", "v")} | {"t": graph.input("t")}
    with pytest.raises(TypeError, match="must not branch on values known only at run time"):
        grid(element_from(kind, np.array([])), OPERATORS["Q"], operands)


def test_a_field_of_memory_needs_a_method_that_remembers():
    with pytest.raises(ElementError, match=r"Forgetful: A Memory field requires a method remember"):

        class Forgetful(ForceElement, bodies=1, derivatives="automatic"):
            turns: Memory

            def Q(self, x, v, t):
                return row(self.turns * x.r)[0], None


def push(q):
    """A system with an element of one's own that returns this for Q."""
    import sarrus as sr
    from sarrus.model.primitive import Primitive

    class Push(ForceElement, bodies=1, derivatives="automatic"):
        f: Vec3

        def Q(self, x, v, t):
            return q(self, x, v, t)

    class Pushed(Force):
        def __init__(self, body):
            object.__setattr__(self, "name", "pushed")
            object.__setattr__(self, "body", body)

        def primitives(self, poses):
            yield Primitive(Push, (self.body,), ((1.0, 0.0, 0.0),), "push")

    body = sr.Body("b", 1.0, (1, 1, 1))

    def forced(name):
        system = sr.System(sr.Model("m", [body], [], [Pushed(name or body)]))
        return system.Q(q=system.q0, v=system.v0, t=0.0)

    return forced


def test_a_body_in_the_place_of_its_name():
    with pytest.raises(ModelError, match=r'force "pushed": .*its bodies must be names, .*Give body\.name'):
        push(lambda self, x, v, t: (self.f, None))("")


WRONG_Q = {
    "one block": lambda self, x, v, t: (self.f,),
    "an array": lambda self, x, v, t: self.f,
    "nothing": lambda self, x, v, t: None,
    "a number": lambda self, x, v, t: 1.0,
    "a short block": lambda self, x, v, t: (self.f[:2], None),
    "a long block": lambda self, x, v, t: (self.f, x.r),
    "a scalar block": lambda self, x, v, t: (self.f[0], None),
}


@pytest.mark.parametrize("what", WRONG_Q)
def test_a_kernel_of_a_wrong_shape_is_named(what):
    with pytest.raises(ElementError, match=r"element Push: Q must return 2 blocks .* of 3, 4 entries"):
        push(WRONG_Q[what])("b")


@pytest.mark.parametrize(
    "wrong",
    [
        lambda row: row[0],
        lambda row: (row[0],),
        lambda row: (row[0][0, 0], None),
        lambda row: (row[0].T[:2], None),
    ],
)
def test_a_written_derivative_of_a_wrong_shape_is_named(wrong):
    """The defect: 'Expression' object has no attribute 'shape'."""
    right = plane()
    kind = type(Constraint)(
        "Odd", (right,), {"Phi_q": lambda self, x: wrong(right.Phi_q(self, x))}, rows=1, bodies=1
    )
    graph = Graph()
    element = element_from(kind, graph.inputs("numbers", kind.size()))
    with pytest.raises(
        ElementError, match=r"element Odd: Phi_q must return 2 blocks .* of 1 rows and 3, 4 columns"
    ):
        grid(element, OPERATORS["Phi_q"], {"q": graph.inputs("q", 7), "t": graph.input("t")})


def test_a_random_kernel_is_refused():
    """It was compiled with the number that it drew first."""
    with pytest.raises(ElementError, match="element Push: Q is another formula each time"):
        push(lambda self, x, v, t: (self.f * np.random.default_rng().normal(), None))("b")
