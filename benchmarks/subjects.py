"""What is compared: the two shipped mechanisms in a general state, and Sarrus and its C twin as things to be timed."""

from __future__ import annotations

import ctypes
import hashlib
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import sarrus.mechanisms
from sarrus.elements import OPERATORS, Operator
from sarrus.elements.operators import Axis
from sarrus.elements.recorder import structure, variants
from sarrus.model import load
from sarrus.system import System
from sarrus.system.structure.population import firsts

HERE = Path(__file__).resolve().parent
_built = Path(tempfile.gettempdir()) / "sarrus-benchmarks"
GCC = ("gcc", "-O3", "-march=native", "-shared", "-fPIC")
MECHANISMS = ("slider_crank", "hmmwv")
GROUPS = ("kinematic", "force", "inertia")
KINDS = {
    "kinematic": ("Spherical", "Dot1", "Dot2", "Distance", "Normalization"),
    "force": ("TSDA", "Tyre"),
    "inertia": ("RigidInertia",),
}
SILENT = {"Gravity"}  # no share in Q_q and Q_v


def use(folder: str) -> None:
    """Build in this folder instead of the kept one."""
    global _built
    _built = Path(folder)


def built() -> Path:
    """The folder of what gcc makes."""
    _built.mkdir(parents=True, exist_ok=True)
    return _built


class Unavailable(Exception):
    """A competitor cannot run here."""


@dataclass
class Case:
    """One mechanism and group, in a state off the unit sphere with ξ = v."""

    name: str
    group_name: str
    system: System
    operands: dict[str, Any]

    def __post_init__(self) -> None:
        self.group = self.system.group(self.group_name)
        self.outputs = self.group.allocate()
        self.arguments = (self.system.b, *(self.operands[n] for n in self.group.operands), *self.outputs)

    @property
    def arrays(self) -> list[np.ndarray]:
        """The operands that are arrays, as the competitors take them: ξ and v apart, which Sarrus's group merges."""
        wanted = {name for operator in self.group.names for name in ("q", *OPERATORS[operator].operands)}
        return [self.operands[name] for name in ("q", "xi", "v", "a", "lam") if name in wanted]

    def run(self) -> list[np.ndarray]:
        """The group by Sarrus."""
        self.group.run(*self.arguments)
        return [out.copy() for out in self.outputs]

    def populations(self) -> list[Any]:
        """The populations of the group's family, in the order of the place tables."""
        family = self.group.patterns[0]
        members = [p for p in self.system.populations if p.kind.family[0].family == _family(self.group_name)]
        known = {*KINDS[self.group_name], *SILENT}
        strange = {p.kind.__name__ for p in members if p.count} - known
        if strange or len(members) != len(family.places):
            raise AssertionError(
                f"the benchmark does not know {', '.join(strange) or 'the order of the tables'}"
            )
        return members

    def dense(self, outputs: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Outputs in Sarrus's storage as dense matrices."""
        return [self.system.matrix(n, x).toarray() for n, x in zip(self.group.names, outputs, strict=True)]


def _family(group: str) -> str:
    return "constraint" if group == "kinematic" else group


def cases(names: Sequence[str] = MECHANISMS) -> list[Case]:
    """Every group of every mechanism."""
    found = []
    for name in names:
        system = System(load(sarrus.mechanisms.path(name)))
        random = np.random.default_rng(5)
        q = system.q0 + 0.01 * random.standard_normal(system.nq)
        v, a = random.standard_normal(system.nq), random.standard_normal(system.nq)
        operands = {"q": q, "v": v, "xi": v.copy(), "a": a, "lam": random.standard_normal(system.m), "t": 0.0}
        found += [Case(name, group, system, operands) for group in GROUPS]
    return found


def compiled_loop(case: Case) -> Callable[[int], None]:
    """A compiled function that calls the group's driver n times."""
    from numba import njit

    names = [f"a{n}" for n in range(len(case.arguments))]
    call = f"index, {', '.join(names)}"
    source = f"def loop(n, {call}):\n    for _ in range(n):\n        run({call})\n"
    namespace: dict[str, Any] = {"run": case.group.compiled}
    exec(source, namespace)
    loop, index, arguments = njit(namespace["loop"]), case.group.index, case.arguments
    loop(1, index, *arguments)
    return lambda n: loop(n, index, *arguments)


def build(source: Path, flags: Sequence[str] = ()) -> Any:
    """Compile a C file to a library, unless that was done before, and load it."""
    command = [*GCC, *flags]
    text = " ".join(command) + _gcc() + source.read_text()
    target = built() / f"{source.stem}-{hashlib.sha256(text.encode()).hexdigest()[:16]}.so"
    if not target.exists():
        partial = target.with_suffix(".part")
        subprocess.run([*command, str(source), "-o", str(partial), "-lm"], check=True)
        partial.replace(target)
    return ctypes.CDLL(str(target))


def _gcc() -> str:
    try:
        return subprocess.run(["gcc", "--version"], check=True, capture_output=True, text=True).stdout
    except OSError as error:
        raise Unavailable("gcc is not installed") from error


def _tables(case: Case, n: int, population: Any) -> list[np.ndarray]:
    """Numbers, bodies, rows and the place tables of a population, -1 where a block is ground's or always zero."""
    tables = []
    for name, pattern in zip(case.group.names, case.group.patterns, strict=True):
        operator, slots = OPERATORS[name], population.variant.slots
        every = structure(variants(population.kind)[0], operator)
        table = np.full((population.count, len(every), 2), -1)
        for k, place in enumerate(structure(population.variant, operator) if population.count else ()):
            table[:, every.index(among_all(place, operator, slots))] = pattern.places[n][:, k]
        tables.append(table)
    numbers = case.system.b[population.at : population.end]
    return [numbers, bodies_of(population), population.rows, *tables]


def bodies_of(population: Any) -> np.ndarray:
    """First coordinate of each body of every element, negative for ground: (count, bodies)."""
    found = np.array([firsts(population, k) for k in range(population.count)], dtype=np.int64)
    return found.reshape(-1, population.kind.bodies)


def among_all(place: tuple[int, ...], operator: Operator, slots: tuple[int, ...]) -> tuple[int, ...]:
    """A block's place counted over all bodies of an element, of its place counted over the moving ones."""
    axes = (*operator.axes, Axis.ROWS)[:2]
    return tuple(
        2 * slots.index(n // 2) + n % 2 if axis is Axis.COORDINATES else n
        for n, axis in zip(place, axes, strict=True)
    )


class _Elements(ctypes.Structure):
    _fields_ = (
        ("count", ctypes.c_long),
        ("numbers", ctypes.c_void_p),
        ("bodies", ctypes.c_void_p),
        ("rows", ctypes.c_void_p),
        ("places", ctypes.c_void_p * 5),
    )


class Twin:
    """A group computed by `twin.c`, into arrays of its own."""

    def __init__(self, case: Case, entry: str = "", flags: Sequence[str] = ()) -> None:
        self.outputs = [np.full_like(out, np.nan) for out in case.outputs]
        self._keep: list[Any] = [case.arrays]
        kinds = KINDS[case.group_name]
        self._elements = (_Elements * len(kinds))()
        for n, kind in enumerate(kinds):
            self._fill(case, kind, self._elements[n])
        self._sizes = np.array([len(out) for out in self.outputs], dtype=np.int64)
        self._function = getattr(build(HERE / "twin.c", flags), entry or case.group_name)
        pointers = [_pointers(arrays) for arrays in (case.arrays, self.outputs)]
        self._where = (ctypes.byref(self._elements), *pointers, ctypes.c_void_p(self._sizes.ctypes.data))

    def loop(self, n: int) -> None:
        """The group n times."""
        self._function(ctypes.c_long(n), *self._where)

    def _fill(self, case: Case, kind: str, to: _Elements) -> None:
        parts = [_tables(case, n, p) for n, p in enumerate(case.populations()) if p.kind.__name__ == kind]
        arrays = [np.concatenate(part) for part in zip(*parts, strict=True)]
        arrays = [arrays[0], *(np.ascontiguousarray(a, dtype=np.int32) for a in arrays[1:])]
        self._keep.append(arrays)
        to.count = len(arrays[1])
        to.numbers, to.bodies, to.rows = (array.ctypes.data for array in arrays[:3])
        for n, table in enumerate(arrays[3:]):
            to.places[n] = table.ctypes.data

    def run(self) -> list[np.ndarray]:
        """The group by C, once."""
        self.loop(1)
        return self.outputs


def _pointers(arrays: Sequence[np.ndarray]) -> Any:
    return (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays))
