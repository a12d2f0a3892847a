"""Forces and moments of a tyre law at many slips, with exact derivatives by its coefficients."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from ...._jit.formulas.differentiate import jacobian
from ...._jit.formulas.expression import Graph
from ...._jit.formulas.replay import function_of
from ....algebra import Array
from .law import Slip, TyreLaw


def sampled(law: TyreLaw, slip: Slip, wrt: Sequence[str] = ()) -> tuple[Array, Array]:
    """F_x, F_y [N], M_x, M_y, M_z [N m] (5, n) at slips, and their derivatives by coefficients (5, n, k).

    Fields of the slip are numbers or arrays (n,). They are limited to the range of the law.
    """
    function = _function(type(law), tuple(law.given), tuple(wrt))
    fields = [np.asarray(field, dtype=float) for field in slip]
    values = function(*(float(value) for value in law.given.values()), *fields)
    columns = np.array(np.broadcast_arrays(*values, *fields, np.zeros(1))[: len(values)], dtype=float)
    return columns[:5], columns[5:].reshape(5, len(wrt), columns.shape[1]).transpose(0, 2, 1)


@lru_cache(100)
def _function(
    kind: type[TyreLaw], names: tuple[str, ...], wrt: tuple[str, ...]
) -> Callable[..., tuple[Any, ...]]:
    """Forces and derivatives of coefficients and slips, as a function of arrays."""
    graph = Graph()
    given = {name: graph.input(name) for name in names}
    fields = {f"slip_{name}": graph.input(f"slip_{name}") for name in Slip._fields}
    law = kind(given)
    forces = law.wrench(law.in_range(Slip(*fields.values())))
    slopes = jacobian(graph, forces, [given[name] for name in wrt])
    return function_of(
        graph, [*forces, *slopes.ravel()], {one.id: name for name, one in (given | fields).items()}
    )
