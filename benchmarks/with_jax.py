"""JAX: a group jitted as one function, derivatives by forward mode, elements of a kind batched by vmap, float64.

The derivatives of the elements are gathered (or, where elements add, scattered) into the storage that Sarrus uses.
"""

from __future__ import annotations

import os

os.environ["XLA_FLAGS"] = os.environ.get("XLA_FLAGS", "") + (
    " --xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
)
os.environ["JAX_PLATFORMS"] = "cpu"

import time
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from definitions import CONSTRAINTS, FORCES, momentum_rate
from subjects import SILENT, Case, among_all, bodies_of

from sarrus.elements import OPERATORS
from sarrus.elements.recorder import structure

jax.config.update("jax_enable_x64", True)
STATES = 50  # per call of the loop


def _along(function: Any, x: Any, v: Any) -> Any:
    return jax.jvp(lambda y: jnp.stack(function(y)), (jnp.stack(list(x)),), (jnp.stack(list(v)),))[1]


def _gradient(function: Any, x: Any) -> Any:
    return jax.grad(lambda y: function(y)[0])(jnp.stack(list(x)))


def _constraint(kind: str) -> Callable[..., list[Any]]:
    def blocks(n: Any, x: Any, xi: Any, v: Any, lam: Any) -> list[Any]:
        def Phi(y: Any) -> Any:
            return jnp.stack(CONSTRAINTS[kind](y, n))

        def along(y: Any, d: Any) -> Any:
            return jax.jvp(Phi, (y,), (d,))[1]

        def gamma(y: Any, d: Any) -> Any:
            return -jax.jvp(lambda z: along(z, d), (y,), (d,))[1]

        gamma_q, gamma_v = jax.jacfwd(gamma, (0, 1))(x, v)
        return [
            jax.jacfwd(Phi)(x),
            jax.hessian(lambda y: lam @ Phi(y))(x),
            jax.jacfwd(along)(x, xi),
            gamma_q,
            gamma_v,
        ]

    return blocks


def _force(kind: str) -> Callable[..., list[Any]]:
    def blocks(n: Any, x: Any, v: Any) -> list[Any]:
        def Q(y: Any, w: Any) -> Any:
            return jnp.stack(FORCES[kind](y, w, n, jnp.sqrt, _gradient, _along))

        return list(jax.jacfwd(Q, (0, 1))(x, v))

    return blocks


def _inertia(kind: str) -> Callable[..., list[Any]]:
    def blocks(n: Any, x: Any, a: Any) -> list[Any]:
        return [jax.jacfwd(lambda y: jnp.stack(momentum_rate(y, n, a)))(x)]

    return blocks


KERNELS = {"kinematic": _constraint, "force": _force, "inertia": _inertia}


def _targets(case: Case, n: int, population: Any, name: str) -> np.ndarray:
    """For every entry of the elements' derivatives: its place in the output, or -1."""
    pattern, height = case.group.patterns[case.group.names.index(name)], 7 * population.kind.bodies
    if case.group_name == "kinematic" and name != "Phi_qT_lam_q":
        height = population.kind.rows
    target = np.full((population.count, height, 7 * population.kind.bodies), -1)
    starts, widths = (0, 3, 7, 10), (3, 4, 3, 4)
    operator, slots = OPERATORS[name], population.variant.slots
    for k, place in enumerate(structure(population.variant, operator)):
        m, c = among_all(place, operator, slots)
        base, stride = pattern.places[n][:, k, 0], pattern.places[n][:, k, 1]
        top, rows = (starts[m], widths[m]) if height == 7 * population.kind.bodies else (0, height)
        for r in range(rows):
            for s in range(widths[c]):
                target[:, top + r, starts[c] + s] = base + r * stride + s
    return target


class Jitted:
    """A group of a mechanism as one jitted function, and a jitted loop over states."""

    def __init__(self, case: Case) -> None:
        members = [
            (n, p) for n, p in enumerate(case.populations()) if p.count and p.kind.__name__ not in SILENT
        ]
        names = case.group.names
        targets = [np.concatenate([_targets(case, n, p, o).reshape(-1) for n, p in members]) for o in names]
        operands = [jnp.asarray(array) for array in case.arrays]
        numbers = jnp.asarray(case.system.b)
        kernel = KERNELS[case.group_name]

        def element_blocks(b: Any, states: Any) -> Any:
            every = []
            for _, p in members:
                count = p.count
                values = b[p.at : p.end].reshape(count, -1)
                bodies = bodies_of(p)
                take = np.where(bodies >= 0, bodies, case.system.nq)[..., None] + np.arange(7)
                per = []
                for k, state in enumerate(states):
                    if case.group_name == "kinematic" and k == 3:
                        per.append(state[p.rows[:, None] + np.arange(p.kind.rows)])
                        continue
                    ground = jnp.array([0.0, 0, 0, 1.0 if k == 0 else 0.0, 0, 0, 0])
                    per.append(jnp.concatenate([state, ground])[take].reshape(count, -1))
                every.append(jax.vmap(kernel(p.kind.__name__))(values, *per))
            return every

        def evaluate(b: Any, *states: Any) -> list[Any]:
            every, results = element_blocks(b, states), []
            for k, name in enumerate(names):
                flat, size = (
                    jnp.concatenate([blocks[k].reshape(-1) for blocks in every]),
                    len(case.outputs[k]),
                )
                wanted = np.flatnonzero(targets[k] >= 0)
                to = targets[k][wanted]
                if OPERATORS[name].sums:
                    results.append(jnp.zeros(size).at[to].add(flat[wanted]))
                else:
                    inverse = np.zeros(size, dtype=np.int64)
                    inverse[to] = wanted
                    results.append(flat[inverse])
            return results

        def over_states(b: Any, many: Any, *states: Any) -> Any:
            return jax.lax.map(lambda q: evaluate(b, q, *states), many)

        started = time.perf_counter()
        self._once = jax.jit(evaluate).lower(numbers, *operands).compile()
        many = jnp.tile(operands[0], (STATES, 1))
        self._many = jax.jit(over_states).lower(numbers, many, *operands[1:]).compile()
        self.compile_seconds = time.perf_counter() - started
        self._arguments = (numbers, *operands)
        self._batch = (numbers, many, *operands[1:])

    def run(self) -> list[np.ndarray]:
        return [np.asarray(out) for out in self._once(*self._arguments)]

    def loop(self, n: int) -> None:
        """At least n evaluations inside one compiled loop; see `rounded`."""
        for _ in range(self.rounded(n) // STATES):
            jax.block_until_ready(self._many(*self._batch))

    @staticmethod
    def rounded(n: int) -> int:
        return max(n // STATES, 1) * STATES

    def calls(self, n: int) -> None:
        """n evaluations, each called from Python."""
        for _ in range(n):
            jax.block_until_ready(self._once(*self._arguments))
