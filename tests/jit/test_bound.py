"""Compiled functions with fixed arguments."""

from typing import NamedTuple

import numpy as np
import pytest

from sarrus._jit.kernels.bound import Bound
from sarrus._jit.kernels.scalars import Scalars
from sarrus._jit.linking.link import compiled, link


class Table(NamedTuple):
    """Weights (n, k) by rows, and a shift."""

    weights: np.ndarray
    rows: np.ndarray
    shift: int


@compiled(entry=True)
def weighted(table: Table, x: np.ndarray, out: np.ndarray) -> float:
    """Fill a sum for each chosen row."""
    for n in range(len(table.rows)):
        out[n] = table.shift
        for k in range(len(x)):
            out[n] += table.weights[table.rows[n], k] * x[k]
    return out[0]


def test_fixed_arguments_are_shared_memory() -> None:
    weights, rows, out = np.arange(6.0).reshape(2, 3), np.array([1, 0], dtype=np.uint32), np.zeros(2)
    bound = Bound(weighted, Table(weights, rows, 10))
    assert bound(np.ones(3), out) == 22.0
    assert out.tolist() == [22.0, 13.0]
    weights[1] = 0.0
    assert bound(np.ones(3), out) == 10.0
    assert Bound(weighted, Table(weights.copy(), rows, 1)).function is bound.function
    assert bound.function(bound.data, np.ones(3), out) == 10.0


def test_the_function_has_no_machine_code_besides() -> None:
    """The code of the bound function contains it: it was compiled as a whole twice, which took twice as long."""
    bound = Bound(weighted, Table(np.zeros((2, 3)), np.zeros(2, dtype=np.uint32), 0))
    called = bound.function.py_func.__globals__["function"]
    assert called.targetoptions["no_cpython_wrapper"]
    assert called is not link(weighted)


class Count(Scalars):
    """A sum, a number of calls, and whether it counts."""

    total: float
    calls: int
    on: bool


class Rule(NamedTuple):
    """A factor, whether it is used, and what is counted."""

    factor: float
    used: bool
    count: Count


@compiled(entry=True)
def counted(rule: Rule, x: float) -> float:
    """Add a number to a sum."""
    if rule.count.on:
        rule.count.total += rule.factor * x if rule.used else x
        rule.count.calls += 1
    return rule.count.total


@pytest.mark.parametrize(
    ("factor", "used", "total"), [(-1.5, True, -3.0), (-1.5, False, 2.0), (np.inf, True, np.inf)]
)
def test_numbers_are_fixed_and_scalars_by_name_are_shared(factor: float, used: bool, total: float) -> None:
    count = Count.zeros()
    count.assign((0.0, 0, True))
    add = Bound(counted, Rule(factor, used, count))
    assert add(2.0) == count.total == total
    count.on = False
    assert add(2.0) == total
    assert (count.calls, count.total) == (1, total)


@pytest.mark.parametrize("wrong", [np.arange(6.0).reshape(2, 3).T, 1j, "text"])
def test_what_has_no_address_is_refused(wrong: object) -> None:
    with pytest.raises(TypeError, match="cannot bind"):
        Bound(weighted, wrong)
