"""Values of elements along a motion: one function that is compiled."""

from __future__ import annotations

from ...._jit.kernels.pointer import KernelTable, call_kernels
from ...._jit.linking.link import compiled
from ....algebra import Array
from ..stepping.nodes import Nodes, between


@compiled(entry=True)
def look(
    entry: KernelTable,
    b: Array,
    places: Array,
    nodes: Nodes,
    parts: Array,
    apart: bool,
    work: Array,
    found: Array,
) -> None:
    """Values at the first node, then at parts of every step; elements remember what they did as the step began."""
    remind(b, places, nodes.memory, 0)
    call_kernels(entry, b, nodes.t[0], nodes.q[0], nodes.v[0], found[0])
    row = 1
    for n in range(len(nodes.t) - 1):
        h = nodes.t[n + 1] - nodes.t[n]
        remind(b, places, nodes.memory, n)
        for s in parts:
            if s == 1.0:
                call_kernels(entry, b, nodes.t[n + 1], nodes.q[n + 1], nodes.v[n + 1], found[row])
            else:
                between(nodes.q[n], nodes.v[n], nodes.a[n], nodes.q[n + 1], nodes.v[n + 1], nodes.a[n + 1],
                        s, h, apart, work[0], work[1], work[2])  # fmt: skip
                call_kernels(entry, b, nodes.t[n] + s * h, work[0], work[1], found[row])
            row += 1


@compiled
def remind(b: Array, places: Array, memory: Array, n: int) -> None:
    """Write what elements remembered at a node to their numbers."""
    for k in range(len(places)):
        b[places[k]] = memory[n, k]
