"""The numerical experiments of the paper, on a mechanism: exact derivatives against finite differences.

Differences: the largest entry of |exact - differenced|, over the largest of |exact|, for falling perturbations, with
forward and central differences. (Central differences of a constraint quadratic in q have no error of their own.) Times:
each group of operators exact, beside finite differences over compiled functions made in the same way; called from
compiled code, interleaved, medians. The functions are computed together in one sweep ("shared") or one by one; the
speed-up is taken over the faster of the two, with central differences, and once more over forward differences.
"""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from .._jit.kernels.differences import SCHEMES, differences, repeated
from ..algebra import Array
from ..elements import GROUPS
from ..elements.operators import DERIVATIVES
from ..system import System
from ..system.structure.group import Group, signature
from .equations.saddle_point import Saddle
from .position.assembly import assemble, project_velocity

STEPS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
FUNCTIONS = {"Phi_q": "Phi", "Phi_qT_lam_q": "Phi_qT_lam", "Phi_q_xi_q": "Phi_q_xi", "M_a_q": "M_a"}
Plan = tuple[tuple[str, ...], str]  # functions, and the operand that is varied
ROUNDS = 15
BATCH_SECONDS = 0.004
# Runs of a batch, of which the fastest is timed: others may have been interrupted
CALIBRATIONS = 5


@dataclass(frozen=True)
class Times:
    """One group: seconds of the exact operators, and of finite differences (functions shared, or one by one)."""

    exact: float
    shared: float
    separate: float
    forward: float

    @property
    def speedup(self) -> float:
        """Against central differences, the faster of the two ways."""
        return min(self.shared, self.separate) / self.exact

    @property
    def speedup_forward(self) -> float:
        """Against forward differences, which are half the work and less exact."""
        return self.forward / self.exact


@dataclass(frozen=True)
class Experiment:
    """All of the paper's figures for one mechanism."""

    name: str
    counts: dict[str, int]
    differences: dict[str, dict[str, list[float]]]
    times: dict[str, Times]

    def as_json(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        found: dict[str, Any] = {"steps": list(STEPS), **self.differences}
        micro = {name: {k: 1e6 * v for k, v in asdict(t).items()} for name, t in self.times.items()}
        return {
            "counts": self.counts,
            "differences": found,
            "speedup": {name: times.speedup for name, times in self.times.items()},
            "speedup_forward": {name: times.speedup_forward for name, times in self.times.items()},
            "microseconds": micro,
        }


def experiment(system: System, *, seed: int = 1) -> Experiment:
    """Run the paper's experiments on an assembled mechanism, at a random consistent velocity.

    Parameters
    ----------
    system : System
    seed : of the random velocity, multipliers and accelerations

    Returns
    -------
    Experiment
    """
    state = consistent_state(system, seed)
    names = [name for group in GROUPS.values() for name in group]
    found = {
        scheme: {name: differences_of(system, name, scheme, state) for name in names} for scheme in SCHEMES
    }
    times = {name: times_of(system, name, state) for name in GROUPS}
    return Experiment(system.name, system.counts(), found, times)


def consistent_state(system: System, seed: int) -> dict[str, Any]:
    """Assembled coordinates, a random velocity that satisfies the constraints, random multipliers and accelerations."""
    random = np.random.default_rng(seed)
    q = assemble(system).q
    v = project_velocity(system, Saddle(system, "I"), q, random.normal(size=system.nq))
    lam, a = random.normal(size=system.m), random.normal(size=system.nq)
    return {"q": q, "v": v, "xi": v, "lam": lam, "a": a, "t": 0.0}


def function_of(name: str) -> tuple[str, str]:
    """The vector function whose derivative an operator is, and what it is differentiated by."""
    return FUNCTIONS.get(name, DERIVATIVES[name].of), DERIVATIVES[name].by


def differences_of(system: System, name: str, scheme: str, state: dict[str, Any]) -> list[float]:
    """Relative differences of one operator for all steps."""
    function, vary = function_of(name)
    group, (exact,) = _exact(system, (name,), state)
    pattern = group.patterns[0]
    matrix = system.matrix(name, exact).toarray()
    difference = Difference(system, (function,), vary, scheme, state)
    scale = abs(exact).max(initial=0.0) if pattern.size else 1.0
    return [float(abs(difference(h)[0].T - matrix).max() / scale) for h in STEPS]


def _exact(system: System, names: tuple[str, ...], state: dict[str, Any]) -> tuple[Any, list[Array]]:
    group = system.group(*names)
    outputs = group.allocate()
    group.run(system.b, *(state[key] for key in group.operands), *outputs)
    return group, outputs


class Difference:
    """Finite differences of a group of functions by one operand, compiled."""

    def __init__(
        self, system: System, functions: tuple[str, ...], vary: str, scheme: str, state: dict[str, Any]
    ) -> None:
        group = system.group(*functions)
        driver, index, self.name = _driver(group)
        self.run = differences(signature(group.names, self.name), driver, vary, scheme)
        operands = [np.copy(state[key]) if key == vary else state[key] for key in group.operands]
        self.columns = [np.zeros((len(state[vary]), pattern.size)) for pattern in group.patterns]
        self.arguments = [
            index,
            system.b,
            *operands,
            *group.allocate(),
            *group.allocate(),
            *self.columns,
        ]

    def __call__(self, h: float) -> list[Array]:
        self.run(h, *self.arguments)
        return self.columns


def _driver(group: Group) -> tuple[Any, Any, str]:
    """What computes a group for all elements, its index tables, and a name for what it does besides the built-in."""
    bundle, indices = group.bundle()
    if len(indices) == 1:
        return group.compiled, group.index, ""
    return bundle, indices, str(bundle.py_func.__name__)


def _timed_group(system: System, name: str, state: dict[str, Any]) -> _Timed:
    group, outputs = _exact(system, GROUPS[name], state)
    driver, index, suffix = _driver(group)
    arguments = [index, system.b, *(state[key] for key in group.operands), *outputs]
    return _Timed(repeated(driver, f"exact_{name}{suffix}", len(arguments)), arguments)


def times_of(system: System, name: str, state: dict[str, Any]) -> Times:
    """Median seconds of one group, exact and differenced, measured alternately; equal plans are measured once."""
    separate: list[Plan] = [((function,), vary) for function, vary in map(function_of, GROUPS[name])]
    shared = _shared(separate)
    ways = {"exact": [_timed_group(system, name, state)]}
    plans = {"shared": (shared, "central"), "separate": (separate, "central"), "forward": (shared, "forward")}
    for way, (plan, scheme) in plans.items():
        if way != "separate" or separate != shared:
            ways[way] = [_timed_difference(system, *part, scheme, state) for part in plan]
    samples = [[sum(timed.seconds() for timed in way) for way in ways.values()] for _ in range(ROUNDS)]
    found = dict(zip(ways, map(float, np.median(samples, axis=0)), strict=True))
    return Times(found["exact"], found["shared"], found.get("separate", found["shared"]), found["forward"])


def _shared(plan: list[Plan]) -> list[Plan]:
    """The same differences with one sweep for each operand that is varied."""
    by_operand: dict[str, list[str]] = {}
    for functions, vary in plan:
        by_operand.setdefault(vary, []).extend(functions)
    return [(tuple(functions), vary) for vary, functions in by_operand.items()]


def _timed_difference(
    system: System, functions: tuple[str, ...], vary: str, scheme: str, state: dict[str, Any]
) -> _Timed:
    difference = Difference(system, functions, vary, scheme, state)
    arguments = [1e-6, *difference.arguments]
    name = f"{scheme}_{vary}_{'__'.join(functions)}{difference.name}"
    return _Timed(repeated(difference.run, name, len(arguments)), arguments)


class _Timed:
    """A compiled loop around one call, with a batch long enough to be timed."""

    def __init__(self, loop: Any, arguments: list[Any]) -> None:
        self.loop, self.arguments, self.batch = loop, arguments, 1
        loop(1, *arguments)
        while (taken := min(self._once() for _ in range(CALIBRATIONS))) < BATCH_SECONDS:
            self.batch = max(2 * self.batch, int(self.batch * BATCH_SECONDS / max(taken, 1e-7)))

    def _once(self) -> float:
        start = time.perf_counter()
        self.loop(self.batch, *self.arguments)
        return time.perf_counter() - start

    def seconds(self) -> float:
        """Seconds of one call."""
        return self._once() / self.batch
