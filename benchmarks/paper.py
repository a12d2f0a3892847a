"""The numerical experiments of the paper, Tables 1 to 6: exact derivatives against finite differences.

    python -m benchmarks.paper [SEED]

Differences: the largest entry of |exact - differenced|, over the largest of |exact|, for falling perturbations, with
forward and central differences. (Central differences of a constraint quadratic in q have no error of their own.) Times:
each group of operators exact, beside finite differences over compiled functions made in the same way; called from
compiled code, interleaved, medians. The functions are computed together in one sweep ("shared") or one by one; the
speed-up is taken over the faster of the two, with central differences, and once more over forward differences.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sarrus import System, assemble, load, mechanisms
from sarrus._jit.kernels.driver import Signature, compile_source
from sarrus.algebra import Array
from sarrus.analyses.equations.projection import Projection
from sarrus.elements import GROUPS
from sarrus.elements.operators import DERIVATIVES
from sarrus.system.structure.group import Group, signature

SCHEMES = ("forward", "central")
KINEMATIC = ("Phi_q", "Phi_qT_lam_q", "Phi_q_xi_q", "gamma_q", "gamma_v")
FORCE = ("Q_q", "Q_v", "M_a_q")
HEADINGS = {"Phi_q_xi_q": "(Phi_q v)_q", "Phi_qT_lam_q": "(Phi_qT lam)_q", "M_a_q": "(M a)_q"}

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
    q, v = Projection(system)(0.0, assemble(system).q, random.normal(size=system.nq))
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


def differences(signature: Signature, driver: Any, vary: str, scheme: str) -> Any:
    """Finite differences of all outputs of a driver by the entries of the operand `vary`.

    Returns
    -------
    compiled function ``(h, index, numbers, *scalars, *arrays, *ahead, *behind, *columns)``
        It writes the transposed derivative of each output into its ``columns`` (one row per entry varied); `ahead` and
        `behind` are work space, one array per output each.
    """
    outputs = signature.outputs
    operands = ", ".join([*signature.scalars, *signature.arrays])
    ahead, behind, columns = ([f"{kind}_{out}" for out in outputs] for kind in ("ahead", "behind", "columns"))
    evaluate_behind = f"driver(index, numbers, {operands}, {', '.join(behind)})"
    central = scheme == "central"
    lines = [
        f"def differences(h, index, numbers, {operands}, {', '.join([*ahead, *behind, *columns])}):",
        f"    factor = {0.5 if central else 1.0} / h",
        *([] if central else [f"    {evaluate_behind}"]),
        f"    for k in range(len({vary})):",
        f"        value = {vary}[k]",
        f"        {vary}[k] = value + h",
        f"        driver(index, numbers, {operands}, {', '.join(ahead)})",
        *([f"        {vary}[k] = value - h", f"        {evaluate_behind}"] if central else []),
        f"        {vary}[k] = value",
    ]
    for front, back, column in zip(ahead, behind, columns, strict=True):
        lines.append(f"        for r in range(len({front})):")
        lines.append(f"            {column}[k, r] = ({front}[r] - {back}[r]) * factor")
    return compile_source(f"{scheme}_{vary}_{signature.name}", lines, {"driver": driver})


def repeated(function: Any, name: str, arguments: int) -> Any:
    """A compiled loop that calls a compiled function n times: ``(n, *arguments)``; for timing without Python."""
    parameters = ", ".join(f"a{k}" for k in range(arguments))
    lines = [f"def repeat(n, {parameters}):", "    for _ in range(n):", f"        function({parameters})"]
    return compile_source(f"repeat_{name}", lines, {"function": function})


def paper_tables(experiments: Sequence[Any], steps: Sequence[float]) -> str:
    """Tables 1 to 3 for the first mechanism, 4 to 6 for the second."""
    text = [_tables(found, steps, 3 * place + 1) for place, found in enumerate(experiments)]
    return "\n\n".join(text)


def _tables(found: Any, steps: Sequence[float], first: int) -> str:
    counts = ", ".join(f"{value} {key.replace('_', ' ')}" for key, value in found.counts.items())
    parts = [
        f"{found.name}: {counts}",
        f"Table {first}. Constraint derivatives: largest relative difference from finite differences",
        _differences(found, steps, KINEMATIC),
        f"Table {first + 1}. Force and inertia derivatives: largest relative difference from finite differences",
        _differences(found, steps, FORCE),
        f"Table {first + 2}. Time of one evaluation in µs, called from compiled code",
        _times(found),
    ]
    return "\n".join(parts)


def _differences(found: Any, steps: Sequence[float], names: Sequence[str]) -> str:
    lines = ["  step   " + "".join(f"{HEADINGS.get(name, name):>18}" for name in names)]
    lines.append("  " + " " * 7 + "".join(f"{'forward  central':>18}" for _ in names))
    for n, step in enumerate(steps):
        pairs = [
            (found.differences["forward"][name][n], found.differences["central"][name][n]) for name in names
        ]
        lines.append(f"  {step:<7.0e}" + "".join(f"  {a:>7.0e}  {b:>7.0e}" for a, b in pairs))
    return "\n".join(lines)


def _times(found: Any) -> str:
    lines = [f"  {'':<11}{'':>9}{'central differences':>24}{'forward':>10}{'speed-up over':>22}"]
    lines.append(
        f"  {'group':<11}{'exact':>9}{'shared':>12}{'one by one':>12}{'':>10}{'central':>12}{'forward':>10}"
    )
    for name, t in found.times.items():
        times = (
            f"{1e6 * t.exact:>9.3f}{1e6 * t.shared:>12.1f}{1e6 * t.separate:>12.1f}{1e6 * t.forward:>10.1f}"
        )
        lines.append(f"  {name:<11}{times}{t.speedup:>12.0f}{t.speedup_forward:>10.0f}")
    return "\n".join(lines)


def main() -> None:
    """Print the tables of both mechanisms."""
    seed = int(sys.argv[1]) if len(sys.argv) > 1 else 1
    systems = [System(load(mechanisms.path(name))) for name in ("slider_crank", "hmmwv")]
    print(paper_tables([experiment(system, seed=seed) for system in systems], STEPS))


if __name__ == "__main__":
    main()
