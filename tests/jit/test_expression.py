"""Recorded arithmetic: what is folded away, what is one node, and that the value is always the same."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from sarrus._jit.formulas.differentiate import directional, jacobian
from sarrus._jit.formulas.expression import Expression, Graph
from sarrus._jit.formulas.replay import needed, replay
from sarrus._jit.formulas.reverse import gradient

OPERATIONS = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "neg": lambda a: -a,
}


@pytest.fixture
def graph():
    return Graph()


@pytest.fixture
def x(graph):
    return graph.input("x", 0)


@pytest.fixture
def y(graph):
    return graph.input("y", 0)


def same(a, b):
    return a.graph is b.graph and a.id == b.id


def test_zeros_and_ones_vanish(x):
    for zero in (0, 0.0, x.graph.constant(0), np.int64(0), np.float64(0)):
        assert (zero * x).constant == 0
        assert (x * zero).constant == 0
        assert same(x + zero, x)
        assert same(zero + x, x)
        assert same(x - zero, x)
        assert same(zero - x, -x)
        assert (zero / x).constant == 0
    for one in (1, 1.0, x.graph.constant(1)):
        assert same(one * x, x)
        assert same(x * one, x)
        assert same(x / one, x)
        assert same(-one * x, -x)


def test_signs_move_out_of_products_and_sums(x, y):
    negative = -x
    assert same(-negative, x)
    assert same((-x) * y, -(x * y))
    assert same(x * (-y), -(x * y))
    assert same((-x) * (-y), x * y)
    assert same(x + (-y), x - y)
    assert same((-x) + y, y - x)
    assert same(x - (-y), x + y)
    assert same((-x) - y, -(x + y))
    assert same(-2 * x, -(2 * x))
    assert (x - x).constant == 0


def test_equal_operations_are_one_node(graph, x, y):
    first = x * y + 2 * x
    count = len(graph.nodes)
    assert same(first, 2 * x + y * x)
    assert same(x - y, -(y - x))
    assert len(graph.nodes) == count + 2  # the difference and its negative
    assert same(graph.input("x", 0), x)


def test_constants_are_computed_while_recording(graph):
    two, three = graph.constant(2), graph.constant(Fraction(3))
    assert [(two + three).constant, (two - three).constant, (two * three).constant] == [5, -1, 6]
    assert (-two).constant == -2
    assert graph.constant(np.float64(1.5)).constant == 1.5


def test_powers_are_products(x):
    assert same(x**2, x * x)
    assert same(x**3, x * x * x)
    assert same(x**4, x * x * (x * x))
    assert same(x**-1, 1 / x)
    assert same(x**0.5, x.call("sqrt"))


@pytest.mark.parametrize(
    "branch",
    [
        bool,
        lambda x: x < 0,
        lambda x: x >= 0,
        lambda x: x == 0,
        lambda x: x != 0,
        lambda x: max(x, 0),
        lambda x: x in (1, 2),
    ],
)
def test_branches_are_refused(x, branch):
    with pytest.raises(TypeError, match="must not branch on values known only at run time"):
        branch(x)


def test_numpy_arrays_of_expressions(graph, x):
    a, b = graph.inputs("a", 3), graph.inputs("b", 3)
    product = a @ b
    assert isinstance(product, Expression)
    assert same(product, a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
    assert (x * a).shape == (a * x).shape == (3,)
    assert same((x * a)[1], a[1] * x)
    assert same(np.sqrt(a)[2], a[2].sqrt())


# ---------------------------------------------------------------------------------------- any formula at all

NUMBERS = st.sampled_from([-3, -2, -1, 0, 1, 2, Fraction(1, 2), Fraction(-5, 3)])
INPUTS = st.sampled_from(["x", "y", "z"])
TREES = st.recursive(
    st.one_of(NUMBERS, INPUTS),
    lambda inner: st.one_of(
        st.tuples(st.sampled_from(["add", "sub", "mul", "div"]), inner, inner),
        st.tuples(st.just("neg"), inner),
    ),
    max_leaves=25,
)
VALUES = st.fractions(min_value=-4, max_value=4, max_denominator=5)


def compute(tree, leaves):
    """The value of a tree: recorded, if its leaves are expressions."""
    if isinstance(tree, tuple):
        return OPERATIONS[tree[0]](*(compute(part, leaves) for part in tree[1:]))
    return leaves[tree] if isinstance(tree, str) else Fraction(tree)


def interpret(expression, leaves):
    """The value of what was recorded, node by node."""
    nodes = expression.graph.nodes

    def value(n):
        node = nodes[n]
        if node.op == "constant":
            return node.value
        if node.op == "input":
            return leaves[node.value[0]]
        return OPERATIONS[node.op](*(value(arg) for arg in node.args))

    return value(expression.id)


@given(TREES, st.tuples(VALUES, VALUES, VALUES))
def test_recorded_formulas_have_the_same_value(tree, values):
    leaves = dict(zip("xyz", values, strict=True))
    try:
        expected = compute(tree, leaves)
        graph = Graph()
        recorded = compute(tree, {name: graph.input(name) for name in leaves})
    except ZeroDivisionError:
        assume(False)
    found = interpret(recorded, leaves) if isinstance(recorded, Expression) else recorded
    assert found == expected


def test_values_that_are_plain_numbers_are_taken_wherever_expressions_are(graph, x):
    values = [3, 0, np.float64(2.5), x * x]
    assert replay(graph, values, {("x", 0): 3.0}) == [3, 0, 2.5, 9.0]
    assert needed(graph, [0]) == [graph.constant(0).id]
    assert jacobian(graph, values, [x]).shape == (4, 1)
    changes = directional(graph, values, [(x, graph.constant(1))])
    assert changes[:3] == [0, 0, 0]
    assert directional(graph, changes, [(x, graph.constant(1))])[:3] == [0, 0, 0]
    assert gradient(graph, 3, [x]) == [0]
