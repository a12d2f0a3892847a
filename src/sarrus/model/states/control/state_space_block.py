"""State space from matrices: ẋ = A x + B u, y = C x + D u."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Annotated, Any, TypeAlias

from ...._jit.formulas.expression import Expression as Recorded
from ...errors import ModelError
from ...forces.by_formula import WithParameters
from ...forces.force import Force
from ...laws.law import Law
from ...laws.recorded import Recording
from ...measure import In
from ...primitive import Primitive
from ...quantity import is_list, numbers
from ...show import quote, show
from ...signals import Signals
from ..block import StateValue
from ..rate_load import rate_loads
from ..with_nominal import WithNominal
from .linear_system import arrays_of

Matrix: TypeAlias = list[tuple[float, ...]]
ROWS = "Give a list of rows, such as [[0, 1], [-4, -0.4]]."


@dataclass(frozen=True, eq=False, kw_only=True)
class StateSpaceBlock(WithParameters, WithNominal, Force):
    """A linear controller, filter or actuator by its matrices, ẋ = A x + B u, y = C x + D u, of several variables.

    Its outputs are ``name.y1``, ``name.y2``, ..., its states ``name.x1``, ``name.x2``, ... An output depends on the
    inputs at the same time only where D is not 0: a loop through other entries is no algebraic loop. All entries are
    parameters, ``name.A.1.2``, but those of D that are 0.

    Parameters
    ----------
    A
        State matrix (n, n).
    B
        Input matrix (n, m).
    C
        Output matrix (p, n).
    D
        Feedthrough matrix (p, m); by default zeros.
    inputs
        m numbers, formulas of outputs, states, ``t`` and ``parameters``, such as ``"0.3 - pin.angle"``, or functions.
    initial
        Initial states (n,), by default zeros.
    unit
        Unit of the outputs, for plots and tables.
    """

    A: Annotated[Sequence[Sequence[float]], In("")]
    B: Annotated[Sequence[Sequence[float]], In("")]
    C: Annotated[Sequence[Sequence[float]], In("")]
    D: Annotated[Sequence[Sequence[float]] | None, In("")] = None
    inputs: Annotated[Sequence[Law], In("", outputs=True)] = ()
    initial: Annotated[Sequence[float] | None, In("")] = None
    unit: str = ""

    @classmethod
    def of(cls, name: str, system: Any, **given: Any) -> StateSpaceBlock:
        """Return the block of a state space of `scipy.signal` or python-control.

        Parameters
        ----------
        name
            Name of the part.
        system
            Object with ``A``, ``B``, ``C`` and ``D``, or with ``to_ss()``.
        given
            ``inputs`` and other fields.

        Raises
        ------
        ModelError
            If it is another object, or in discrete time.
        """
        A, B, C, D = arrays_of(system, "to_ss", "ABCD", f"state space block {quote(name)}")
        return cls(name, A=A, B=B, C=C, D=D, **given)

    def _matrix(self, field: str, rows: int | None, columns: int | None) -> Matrix:
        """A checked matrix; None for a size that it determines."""
        given: Any = getattr(self, field)
        if not is_list(given) or not len(given) or not all(is_list(row) and len(row) for row in given):
            raise _no_matrix(field, given)
        high, wide = rows or len(given), columns or len(given[0])
        if len(given) != high:
            remedy = f"Give {high} x {wide} numbers."
            raise ModelError(f"{field} must have {high} rows, but has {len(given)}. {remedy}", field=field)
        return [numbers(row, wide, f"{field}, row {n},", ROWS) for n, row in enumerate(given, 1)]

    def _order(self) -> int:
        """The number of states."""
        if not is_list(self.A):
            raise _no_matrix("A", self.A)
        if not len(self.A):
            message = "A has no states. Give a gain without states as a formula where it is used."
            raise ModelError(message, field="A")
        return len(self.A)

    def _checked_inputs(self) -> int:
        """The number of inputs."""
        if not is_list(self.inputs) or not len(self.inputs):
            message = f"inputs must be a list of formulas, but is {show(self.inputs)}. Give one for each column of B."
            raise ModelError(message, field="inputs")
        return len(self.inputs)

    def _outputs(self) -> tuple[Matrix, Matrix]:
        """C and D."""
        C = self._matrix("C", None, self._order())
        D = self._matrix("D", len(C), self._checked_inputs()) if self.D is not None else []
        return C, D or [(0.0,) * len(self.inputs)] * len(C)

    @property
    def absent_numbers(self) -> Collection[tuple[str | int, ...]]:
        """The zeros of D, through which nothing passes."""
        rows: Any = self.D if is_list(self.D) else ()
        return [
            ("D", k, n)
            for k, row in enumerate(rows)
            if is_list(row)
            for n, entry in enumerate(row)
            if entry == 0.0
        ]

    def _names(self) -> list[str]:
        return [f"{self.name}.x{n}" for n in range(1, self._order() + 1)]

    def states(self) -> Iterator[StateValue]:
        """Yield its states."""
        names = self._names()
        given = [0.0] * len(names) if self.initial is None else self.initial
        initial = numbers(given, len(names), "initial", "Give one for each row of A.")
        for name, one in zip(names, initial, strict=True):
            yield StateValue(name, one, nominal=self.state_size())

    def variables(self) -> Iterator[tuple[str, Any]]:
        """Yield the outputs."""
        checked = cache(self._outputs)  # where the first output is recorded, once for all
        for k in range(len(self.C) if is_list(self.C) else 0):
            yield f"{self.name}.y{k + 1}", partial(self._output, checked, k)

    def _input(self, r: Recording, n: int) -> Recorded:
        """One of its inputs."""
        return self.recorded_law(r, "inputs", self.inputs[n])

    def _output(self, checked: Callable[[], tuple[Matrix, Matrix]], k: int, r: Recording) -> Recorded:
        """One of its outputs."""
        C, D = checked()
        found = self._of_states(r, C[k])
        for n, entry in enumerate(D[k]):
            if entry != 0.0:
                found = found + r.number(entry) * self._input(r, n)
        return found

    def _of_states(self, r: Recording, row: Sequence[float]) -> Recorded:
        """A row of A or C times x."""
        found = r.graph.constant(0.0)
        for name, entry in zip(self._names(), row, strict=True):
            found = found + r.number(entry) * r.named(name)
        return found

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the loads of its rates."""
        n, m = self._order(), self._checked_inputs()
        A, B = self._matrix("A", n, n), self._matrix("B", n, m)
        self._outputs()  # also where C has no rows
        r = Recording("inputs", {}, self.checked_parameters(), variables=signals.variables)
        u = [self._input(r, k) for k in range(m)]
        rates = [
            sum((r.number(entry) * one for entry, one in zip(b, u, strict=True)), self._of_states(r, a))
            for a, b in zip(A, B, strict=True)
        ]
        outputs = {name.rpartition(".")[2]: (record(r), self.unit) for name, record in self.variables()}
        yield from rate_loads(self._names(), rates, r, signals, outputs=outputs)


def _no_matrix(field: str, given: Any) -> ModelError:
    return ModelError(f"{field} must be a matrix, but is {show(given)}. {ROWS}", field=field)
