"""Control: state-space blocks, transfer functions, lags and PID controllers, whose inputs and outputs are signals."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Annotated, Any, TypeAlias

import numpy as np

from ..._jit.formulas.expression import Expression as Recorded
from ...functions import maximum, minimum
from ..errors import ModelError
from ..forces.by_formula import WithParameters
from ..forces.force import Force
from ..laws.law import Law
from ..laws.recorded import Recording
from ..measure import In
from ..primitive import Primitive
from ..quantity import is_list, number, numbers, positive
from ..show import quote, show
from ..signals import Signals
from .block import InputOutputBlock, StateValue, WithInput, WithNominal, rate_loads


def arrays_of(system: Any, convert: str, fields: str | tuple[str, ...], part: str) -> list[Any]:
    """Return arrays of a linear system in continuous time, as lists.

    Parameters
    ----------
    system
        An object of `scipy.signal` or python-control.
    convert
        Its method that returns the same system with these fields, ``to_ss`` or ``to_tf``, if it has one.
    fields
        Names of the arrays.
    part
        The part that is made of it, for messages.

    Raises
    ------
    ModelError
        If it is no such object, or in discrete time.
    """
    if getattr(system, "dt", None):
        raise ModelError("system has a sampling time. Give one in continuous time.", part=part)
    found = getattr(system, convert)() if hasattr(system, convert) else system
    if not all(hasattr(found, field) for field in fields):
        message = f"system must be a linear system of scipy.signal or python-control, but is {show(system)}"
        raise ModelError(f"{message}. Give one, or {', '.join(fields)} by name.", part=part)
    return [np.asarray(getattr(found, field)).tolist() for field in fields]


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
        names = self._names()
        given = [0.0] * len(names) if self.initial is None else self.initial
        initial = numbers(given, len(names), "initial", "Give one for each row of A.")
        for name, one in zip(names, initial, strict=True):
            yield StateValue(name, one, nominal=self.state_size())

    def variables(self) -> Iterator[tuple[str, Any]]:
        checked = cache(self._outputs)  # where the first output is recorded, once for all
        for k in range(len(self.C) if is_list(self.C) else 0):
            yield f"{self.name}.y{k + 1}", partial(self._output, checked, k)

    def _input(self, r: Recording, n: int) -> Recorded:
        return self.recorded_law(r, "inputs", self.inputs[n])

    def _output(self, checked: Callable[[], tuple[Matrix, Matrix]], k: int, r: Recording) -> Recorded:
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


COEFFICIENTS = "Give those of s² + 3 s + 2 as [1, 3, 2]."


@dataclass(frozen=True, eq=False, kw_only=True)
class TransferFunction(InputOutputBlock, WithNominal, Force):
    """A linear controller or filter by its transfer function, from rest.

    Its output is ``name.output``, its states ``name.x1``, ``name.x2``, ... are those of the controller canonical form:
    ẋ₁ = input - a₁ x₁ - … - a_n x_n, ẋ_k = x_(k-1), for a₀ = 1.

    Parameters
    ----------
    numerator, denominator
        Coefficients of falling powers of s, as of `scipy.signal.TransferFunction`; the numerator has no more than the
        denominator.
    unit
        Unit of the output, for plots and tables.
    """

    numerator: Annotated[Sequence[float], In("")]
    denominator: Annotated[Sequence[float], In("")]
    unit: str = ""

    @classmethod
    def of(cls, name: str, system: Any, **given: Any) -> TransferFunction:
        """Return the block of a transfer function of `scipy.signal` or python-control with one input and one output.

        Parameters
        ----------
        name
            Name of the part.
        system
            Object with ``num`` and ``den``, or with ``to_tf()``.
        given
            ``input`` and other fields.

        Raises
        ------
        ModelError
            If it is another object, in discrete time, or has several inputs or outputs.
        """
        part = f"transfer function {quote(name)}"
        arrays = arrays_of(system, "to_tf", ("num", "den"), part)
        above, below = (_flat(values, part) for values in arrays)
        return cls(name, numerator=above, denominator=below, **given)

    @property
    def absent_numbers(self) -> Collection[tuple[str | int, ...]]:
        """The first coefficient of a numerator that is as long as the denominator, if nothing passes through it."""
        above, below = self.numerator, self.denominator
        given = is_list(above) and is_list(below) and 0 < len(above) == len(below)
        return [("numerator", 0)] if given and not above[0] else ()

    def _coefficients(self, field: str) -> list[float]:
        """Its coefficients, which must be numbers."""
        given: Any = getattr(self, field)
        return [*numbers(given, len(given) if is_list(given) else 1, field, COEFFICIENTS)]

    def _checked(self) -> tuple[list[Any], list[Any]]:
        """Numerator with leading zeros, and denominator."""
        above, below = (self._coefficients(field) for field in ("numerator", "denominator"))
        if len(below) < 2 or below[0] == 0.0:
            message = (
                f"denominator must have two coefficients, the first not 0, but is {show(self.denominator)}"
            )
            raise ModelError(f"{message}. {COEFFICIENTS}", field="denominator")
        if not 0 < len(above) <= len(below):
            message = "numerator must have as many coefficients as the denominator, or less. Add poles."
            raise ModelError(message, field="numerator")
        return [0.0] * (len(below) - len(above)) + above, below

    def states(self) -> Iterator[StateValue]:
        for n in range(1, len(self._checked()[1])):
            yield StateValue(f"{self.name}.x{n}", 0.0, nominal=self.state_size())

    def laws(self, r: Recording) -> tuple[list[Recorded], Recorded]:
        """Return its rates, and its output."""
        above, below = ([r.number(value) for value in values] for values in self._checked())
        x = [r.named(f"{self.name}.x{n}") for n in range(1, len(below))]
        first = self.recorded_input(r)
        for a, one in zip(below[1:], x, strict=True):
            first = first - a / below[0] * one
        through = above[0] / below[0] * first if any(self._checked()[0][:1]) else 0.0
        return [first, *x[:-1]], through + self._of_states(r)

    def recorded_output(self, recording: Recording) -> Recorded:
        return self.laws(recording)[1] if any(self._checked()[0][:1]) else self._of_states(recording)

    def _of_states(self, r: Recording) -> Recorded:
        """Its output, where it does not depend on the input itself."""
        above, below = self._checked()
        scale, found = r.number(below[0]), r.graph.constant(0.0)
        for n, b in enumerate(above[1:], 1):
            found = found + r.number(b) / scale * r.named(f"{self.name}.x{n}")
        return found


def _flat(values: Any, part: str) -> list[float]:
    """The coefficients of one input and one output."""
    while hasattr(values, "__len__") and hasattr(values[0], "__len__"):
        if len(values) > 1:
            message = "system has several inputs or outputs. Give one transfer function for each."
            raise ModelError(message, part=part)
        values = values[0]
    return [float(value) for value in values]


@dataclass(frozen=True, eq=False, kw_only=True)
class FirstOrderLag(WithInput, WithNominal, Force):
    """A sensor, filter or actuator x with time · ẋ + x = gain · input. Its output is its name.

    Parameters
    ----------
    time
        Time constant [s].
    gain
        Of its input.
    initial
        Its value at the start of a run.
    unit
        Of x, for plots and tables.
    """

    time: Annotated[float, In("s")]
    gain: Annotated[float, In("")] = 1.0
    initial: Annotated[float, In("")] = 0.0
    unit: str = ""

    def states(self) -> Iterator[StateValue]:
        yield StateValue(self.name, number(self.initial, "initial"), self.unit, self.state_size())

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the load of its rate."""
        r = self.recording("input", signals)
        time, gain = positive(self.time, "time", "Give a time constant in s."), number(self.gain, "gain")
        rate = (r.number(gain) * self.recorded_input(r) - r.named(self.name)) / r.number(time)
        yield from rate_loads([self.name], [rate], r, signals, f"{self.unit or '1'}/s")


@dataclass(frozen=True, eq=False, kw_only=True)
class PID(InputOutputBlock, WithNominal, Force):
    """A controller of an error e, its ``input``: u = kp e + ki ∫e dt + kd ė, within limits.

    The derivative is filtered, ė ≈ (e - f) / filter with ḟ = (e - f) / filter. Where u is limited, the integral follows
    by back-calculation, ∫(e + (limited - u) / (ki · tracking)) dt. Its output is ``name.output``, its states are
    ``name.integral`` and ``name.filtered``.

    Parameters
    ----------
    kp, ki, kd
        Gains of the error, of its integral [1/s] and of its derivative [s].
    filter
        Time constant of the derivative's filter [s]; needed with kd.
    lower, upper
        Limits of u.
    tracking
        Time constant of the anti-windup [s].
    unit
        Of u, for plots and tables.
    """

    kp: Annotated[float, In("")] = 0.0
    ki: Annotated[float, In("")] = 0.0
    kd: Annotated[float, In("")] = 0.0
    filter: Annotated[float | None, In("s")] = None
    lower: Annotated[float | None, In("")] = None
    upper: Annotated[float | None, In("")] = None
    tracking: Annotated[float, In("s")] = 0.1
    unit: str = ""

    @property
    def absent_numbers(self) -> Collection[tuple[str, ...]]:
        """Gains that are 0 where others have a further term, by the derivative's filter or by limits."""
        limited = self.lower is not None or self.upper is not None
        absent = {"kd": not self.kd and self.filter is None, "ki": not self.ki and limited}
        return [(name,) for name, one in absent.items() if one]

    def states(self) -> Iterator[StateValue]:
        """Yield the integral of the error and its filtered value."""
        if self.kd and self.filter is None:
            raise ModelError("filter is missing, which kd needs. Give a time constant in s.", field="filter")
        yield StateValue(f"{self.name}.integral", 0.0, nominal=self.state_size())
        if self.filter is not None:
            yield StateValue(f"{self.name}.filtered", 0.0, nominal=self.state_size())

    def laws(self, r: Recording) -> tuple[list[Recorded], Recorded]:
        """Return its rates, and its output."""
        e, integral = self.recorded_input(r), r.named(f"{self.name}.integral")
        u = r.number(number(self.kp, "kp")) * e + r.number(number(self.ki, "ki")) * integral
        rates = []
        if self.filter is not None:
            time = r.number(positive(self.filter, "filter", "Give a time constant in s."))
            slope = (e - r.named(f"{self.name}.filtered")) / time
            u, rates = u + r.number(number(self.kd, "kd")) * slope, [slope]
        limited = u
        if self.lower is not None:
            limited = maximum(limited, r.number(number(self.lower, "lower")))
        if self.upper is not None:
            limited = minimum(limited, r.number(number(self.upper, "upper")))
        if limited is not u:
            back = r.number(positive(self.tracking, "tracking", "Give a time constant in s."))
            if self.ki:
                e = e + (limited - u) / (r.number(number(self.ki, "ki")) * back)
            else:
                e = (
                    -integral / back
                )  # nothing depends on it, so that it rests where the error does not vanish
        return [e, *rates], limited
