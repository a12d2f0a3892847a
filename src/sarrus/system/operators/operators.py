"""Evaluation of one operator of a system: shapes are checked, patterns and kernels created at first use."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from ...algebra import Array
from ...elements import GROUPS, OPERATORS
from ...elements.operators import Axis
from ...model.show import show, suggest
from ..layout import Layout
from ..structure.group import Group
from ..structure.pattern import Pattern
from ..structure.population import Population
from ..structure.structure import Magnitude, Structure


class Operators:
    """Evaluates operators by name; `System` gives them their public names."""

    populations: list[Population]
    nq: int
    layout: Layout
    m: int
    b: Array
    structure: Structure

    @property
    def moving(self) -> int:
        """Number of coordinates of bodies; those of blocks of states follow them."""
        return self.layout.moving.size

    def pattern(self, name: str) -> Pattern:
        """The fixed sparse pattern of an operator."""
        known = self.structure.patterns
        if name not in known:
            known[name] = self.structure.axes.pattern(OPERATORS[name])
        return known[name]

    def group(self, *names: str) -> Group:
        """A group of operators that are computed in one compiled call.

        Parameters
        ----------
        names : operators of one family, or one of the groups "kinematic", "force", "inertia"

        Returns
        -------
        Group
            ``group.run(system.b, *operands, *outputs)``, which checks no lengths; see `Group`.

        Raises
        ------
        ValueError
            If there is no such operator, or they are of several families.
        """
        chosen = GROUPS.get(names[0], names) if len(names) == 1 else names
        known = self.structure.groups
        if chosen not in known:
            _refuse_mixed(chosen)
            patterns = [self.pattern(name) for name in chosen]
            known[chosen] = Group(chosen, self.structure.axes.populations, patterns)
        return known[chosen]

    def compilable(self) -> list[tuple[str, ...]]:
        """Every operator by itself, and the groups."""
        return [*((name,) for name in OPERATORS), *(names for names in GROUPS.values() if len(names) > 1)]

    def compile(
        self, progress: Callable[[str], None] | None = None, chosen: Sequence[tuple[str, ...]] | None = None
    ) -> None:
        """Compile all kernels now (or load them from the cache) instead of at their first use.

        Parameters
        ----------
        progress : called with a name before each
        chosen : those to compile, in this order; all of `compilable` by default
        """
        for names in self.compilable() if chosen is None else chosen:
            if progress:
                progress(" ".join(names))
            group = self.group(*names)
            operands = {"t": 0.0, "lam": np.zeros(self.m)}
            group.run(
                self.b, *(operands.get(key, np.ones(self.nq)) for key in group.operands), *group.allocate()
            )

    def magnitude(self, name: str, /, *, b: Any = None, **operands: Any) -> Any:
        """Sum of the absolute contributions of all elements to an operator whose components are such sums.

        Parameters
        ----------
        name : for example "Q" or "Phi_qT_lam_q"
        b : other numbers of the elements than the system's
        operands : q, and what else the operator takes: v, t, lam, a, xi

        Returns
        -------
        ndarray (nq,) or csr_array (nq, nq)
        """
        known = self.structure.magnitudes
        if name not in known:
            known[name] = Magnitude(self.structure.axes, OPERATORS[name], self.pattern(name))
        checked = {key: self._operand(key, value) for key, value in operands.items()}
        numbers = self.b if b is None else self._vector("b", b, len(self.b))
        found = known[name](numbers, [checked[key] for key in known[name].operands])
        return found if OPERATORS[name].is_vector else self.matrix(name, found)

    def matrix(self, name: str, data: Array) -> csr_array:
        """The values of an operator as a sparse matrix that shares their memory."""
        return self.pattern(name).matrix(data)

    def _evaluate(self, name: str, out: Any, b: Any, /, **operands: Any) -> Any:
        group = self.group(name)
        checked = {key: self._operand(key, value) for key, value in operands.items()}
        numbers = self.b if b is None else self._vector("b", b, len(self.b))
        result = self._output(name, out)
        data = result if isinstance(result, np.ndarray) else result.data
        if out is not None and any(np.may_share_memory(data, x) for x in (*checked.values(), numbers)):
            raise ValueError(f"`out` of {name} must not share memory with an operand. Give another array.")
        group.run(numbers, *(checked[key] for key in group.operands), data)
        return result

    def _vector_of(self, name: str, out: Any, b: Any, /, **operands: Any) -> Array:
        result: Array = self._evaluate(name, out, b, **operands)
        return result

    def _operand(self, key: str, value: Any) -> Any:
        if key == "t":
            return float(value)
        return self._vector(key, value, self.m if key == "lam" else self.nq)

    @staticmethod
    def _vector(key: str, value: Any, length: int) -> Array:
        if type(value) is np.ndarray and value.dtype == float and value.shape == (length,):
            return np.ascontiguousarray(value)
        if np.iscomplexobj(value):
            raise TypeError(f"{key} must be real, got complex numbers. Give the real part.")
        try:
            vector = np.ascontiguousarray(value, dtype=float)
        except (TypeError, ValueError):
            raise TypeError(f"{key} must be {length} numbers, got {show(value)}. Give an array.") from None
        if np.shape(value) != (length,):
            raise ValueError(
                f"{key} must have shape ({length},), got {np.shape(value)}. Pass an array of this shape."
            )
        return vector

    def _output(self, name: str, out: Any) -> Any:
        pattern = self.pattern(name)
        if out is None:
            fresh = np.zeros(pattern.size)
            return fresh if OPERATORS[name].is_vector else self.matrix(name, fresh)
        if not self._fits(name, out):
            kind = "a float array" if OPERATORS[name].is_vector else "a matrix"
            raise ValueError(
                f"`out` must be {kind} returned by an earlier call of {name} of this system. Leave it out."
            )
        return out

    def _fits(self, name: str, out: Any) -> bool:
        """Whether an object can receive an operator's result: the right kind, shape and pattern, and writable."""
        pattern = self.pattern(name)
        if OPERATORS[name].is_vector:
            return isinstance(out, np.ndarray) and _holds(out, pattern.size)
        if not isinstance(out, csr_array) or out.shape != pattern.shape or not _holds(out.data, pattern.size):
            return False
        return np.array_equal(out.indptr, pattern.indptr) and np.array_equal(out.indices, pattern.indices)

    def atoms(self, axis: Axis) -> Array:
        """First indices of the blocks along an axis: equations of elements, r and p of bodies, fields of elements."""
        found = self.structure.axes.atoms(axis)
        return found.start[found.width > 0]

    def axis_names(self, axis: Axis) -> list[str]:
        """A name for every row or column along an axis, e.g. ``crank.r.x``, ``pin: point x`` or ``spring[tsda].k``."""
        return _NAMES[axis](self)


def _refuse_mixed(names: tuple[str, ...]) -> None:
    """Raise a ValueError unless the names are operators of one family."""
    if not names:
        raise ValueError(
            f"A group needs at least one operator. Choose from {', '.join(GROUPS)}, or operators."
        )
    for name in names:
        if name not in OPERATORS:
            known = [*OPERATORS, *GROUPS]
            raise ValueError(f"group: there is no operator {name!r}. {suggest(str(name), known)}")
        if OPERATORS[name].family != OPERATORS[names[0]].family:
            family, other = OPERATORS[names[0]].family, OPERATORS[name].family
            raise ValueError(
                f"{names[0]} is of the family {family}, but {name} of {other}. Give one group for each family."
            )


def _holds(data: Any, size: int) -> bool:
    """Whether an array can receive the values of an operator."""
    fits = isinstance(data, np.ndarray) and data.shape == (size,) and data.dtype == np.float64
    return fits and bool(data.flags.c_contiguous and data.flags.writeable)


def _coordinate_names(system: Any) -> list[str]:
    return list(system.layout.names)


def _row_names(system: Any) -> list[str]:
    names, layout = [""] * system.m, system.layout
    for p in system.populations:
        for k in range(p.count if p.kind.rows else 0):
            body = layout.owners[layout.owner_of[p.bodies[k, 0]]] if p.kind.bodies == 1 else ""
            owner = p.owners[k] or body
            several = "xyz" if p.kind.rows <= 3 else "123456"
            for n in range(p.kind.rows):
                names[p.rows[k] + n] = f"{owner}: {p.labels[k]}" + (
                    f" {several[n]}" if p.kind.rows > 1 else ""
                )
    return names


COMPONENTS = {
    "Vec3": (".x", ".y", ".z"),
    "Inertia": (".xx", ".yy", ".zz", ".xy", ".xz", ".yz"),
    "Time": (),
    "Vec6": tuple(f".{m}" for m in range(1, 7)),
    "Mat66": tuple(f".{m}{n}" for m in range(1, 7) for n in range(1, 7)),
}


def _parameter_names(system: Any) -> list[str]:
    names: list[str] = []
    for p in system.populations:
        numbers = {f: kind for f, kind in p.kind.fields.items() if kind != "Time"}
        fields = [f + part for f, kind in numbers.items() for part in COMPONENTS.get(kind, ("",))]
        for owner, label in zip(p.owners, p.labels, strict=True):
            names += [f"{owner}[{label}].{field}" for field in fields]
    return names


_NAMES = {Axis.COORDINATES: _coordinate_names, Axis.ROWS: _row_names, Axis.PARAMETERS: _parameter_names}
