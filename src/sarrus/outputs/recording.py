"""The parts of a system along a motion as traced numbers: elements, coordinates, multipliers, laws of curves."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from math import tau
from typing import Any, NamedTuple, Protocol, TypeVar, cast

import numpy as np

from .._jit.formulas.expression import Expression, Graph
from .._jit.formulas.replay import ARRAYS, needed, replay
from ..algebra import Array
from ..elements.evaluation import element_from, partition
from ..elements.recorder import record_scalars
from ..model import SarrusError
from ..model.geometry.points import GROUND
from ..model.tape import Operation, Tape, Tracer, value_of
from ..system import JointCoordinates, System
from ..system.curves.curve_derivatives import MANY, CurveDerivatives, tables_of
from ..system.structure.population import GROUND as STILL
from ..system.structure.population import Population, owners
from .output import UnknownOutput

T = TypeVar("T")
Key = tuple[str, Any]  # kind, and place; of modes, the mode and what it has
Variable = Callable[[str, float], Tracer]


class Motion(Protocol):
    """States at some times (nt,), (nt, nq); `lam` gives the multipliers as they are reported (nt, m)."""

    @property
    def t(self) -> Array: ...
    @property
    def q(self) -> Array: ...
    @property
    def v(self) -> Array: ...
    @property
    def a(self) -> Array: ...
    @property
    def lam(self) -> Callable[[], Array]: ...


class States(NamedTuple):
    """States that are known, see `Motion`."""

    t: Array
    q: Array
    v: Array
    a: Array
    lam: Callable[[], Array]


class Angles:
    """The joints' coordinates, and the rotations of bodies about global axes, with all their revolutions.

    Parameters
    ----------
    system : System
    nodes : states so near to each other that revolutions can be counted
    first : gives the coordinates at the first of them; by default they have less than a turn there
    revolutions : (nt, nc) where they are known at the nodes, which may then be far apart
    """

    def __init__(
        self,
        system: System,
        nodes: Motion,
        first: Callable[[], Array] | None = None,
        revolutions: Array | None = None,
    ) -> None:
        self._system, self._nodes, self._first = system, nodes, first
        self._revolutions = revolutions

    @cached_property
    def values(self) -> Array:
        """At the nodes (nt, nc), see `System.counted_coordinates`."""
        return self._along(self._system.counted_coordinates)

    @cached_property
    def _of_joints(self) -> Array:
        return self._along(self._system.joint_coordinates)

    def _along(self, of: JointCoordinates) -> Array:
        """Coordinates at the nodes (nt, nc)."""
        nodes = self._nodes
        values, _ = of.along(nodes.t, nodes.q, nodes.v, self._revolutions)
        whole = 0.0 if self._first is None else np.round((self._first()[: of.m] - values[0]) / tau)
        return np.asarray(values + tau * whole)

    def near(self, name: str, t: Array) -> Array:
        """A coordinate at times between the nodes, to less than half a turn."""
        n = self._system.counted_coordinates.index(name)
        values = self._of_joints if n < self._system.joint_coordinates.m else self.values
        return np.interp(t, self._nodes.t, values[:, n])


class Recording:
    """A motion on a tape; each number represents its values at all times.

    `about` is a result about its state, if there is one: `Modes`, or the `StateSpace` of a linearization.

    Parameters
    ----------
    system : System
    states : the motion
    b : (len(system.b),) numbers of the elements
    parameters : gives a number of the model by name, made of variables
    angles : with their revolutions; by default counted along the states
    memory : what elements remember at the times (nt,), by place in b; by default as in b
    sides : of kinks, see `Tape`

    Attributes
    ----------
    t : the time [s]
    inputs : what was asked for, by kind and place
    """

    about: object = None

    def __init__(
        self,
        system: System,
        states: Motion,
        b: Array,
        parameters: Callable[[str, Variable], Any],
        angles: Angles | None = None,
        memory: Mapping[int, Array] | None = None,
        sides: Sequence[Array] = (),
    ) -> None:
        self.tape = Tape(sides)
        self.inputs: dict[Key, Tracer] = {}
        self.named: dict[str, Tracer] = {}
        self._vectors: dict[tuple[Any, ...], Any] = {}
        self.system, self.states, self._b, self._parameters = system, states, b, parameters
        self._angles, self._memory = angles or Angles(system, states), memory or {}
        self.t = self.tape.variable(states.t)

    def constant(self, value: Any) -> Tracer:
        """A number, or one for each time, that depends on nothing."""
        return self.tape.add("constant", (), value)

    def element(self, p: Population, k: int, numbers: str) -> Any:
        """An element of recorded numbers, of the equations ("b") or of the joints' coordinates ("c")."""
        at, size = p.at + k * p.kind.size(), p.kind.size()
        own = np.array([self._number(numbers, n) for n in range(at, at + size)], dtype=object)
        element: Any = element_from(p.kind, own, self._b, self.t)
        return replace(element, **{field: law for field, (_, law) in self._laws(p, k).items()})

    def scalars(self, p: Population, k: int, method: str, arguments: int) -> list[Tracer]:
        """Return the result of a method of an element; see `record_scalars`."""
        recording = record_scalars(p.variant, method, arguments)
        found = [block[0] for block in recording.outputs[0].blocks]
        graph = recording.graph
        wanted = graph.expressions(found)
        return self.shared((id(p), k, method), lambda: self.replayed(p, k, graph, wanted))

    def shared(self, key: tuple[Any, ...], record: Callable[[], T]) -> T:
        """Return a recorded result that several outputs share."""
        if key not in self._vectors:
            self._vectors[key] = record()
        return cast(T, self._vectors[key])

    def replayed(self, p: Population, k: int, graph: Graph, wanted: list[Expression]) -> list[Tracer]:
        """Return the recording of a kind of element evaluated for one element."""
        laws = dict(self._laws(p, k).values())
        names = [graph.nodes[n].value for n in needed(graph, wanted) if graph.nodes[n].op == "input"]
        inputs = {name: self._of_element(p, k, name, laws) for name in names}
        return replay(graph, wanted, inputs, TRACED)

    def _of_element(self, p: Population, k: int, name: tuple[Any, ...], laws: Mapping[int, Any]) -> Any:
        """An input of a kernel: ``("t",)``, ``("numbers", n)``, ``("q", body, n)``, ``("v", body, n)``."""
        kind, *place = name
        if kind == "t":
            return self.t
        if kind == "numbers":
            (n,) = place
            return laws[n] if n in laws else self._number("b", p.at + k * p.kind.size() + n)
        body, n = place
        return self.input(kind, int(p.bodies[k, body]) + n)

    def _laws(self, p: Population, k: int) -> dict[str, tuple[int, CurveOnTape | SurfaceOnTape]]:
        """The curves and surfaces of an element by field, with the places of their numbers."""
        places = np.cumsum([0, *p.kind.widths()]).tolist()
        fields = zip(places, p.kind.fields.items(), strict=False)
        return {name: (at, ON_TAPE[kind](self, p, k, at)) for at, (name, kind) in fields if kind in ON_TAPE}

    def _number(self, kind: str, n: int) -> Tracer:
        """Return one parameter of an element; state variables are constants."""
        return self.constant(self._memory[n]) if kind == "b" and n in self._memory else self.input(kind, n)

    def local(self, p: Population, k: int, kind: str, *, states: bool = True) -> Any:
        """Coordinates, or velocities, of an element's bodies; without `states`, blocks of states stand still."""
        end = self.system.nq if states else self.system.moving
        ground = STILL if kind == "q" else np.zeros_like(STILL)
        parts = [
            ground if first < 0 else np.zeros(width) if first >= end
            else [self.input(kind, n) for n in range(first, first + width)]
            for first, width in owners(p, k)
        ]  # fmt: skip
        return partition(p.kind, np.array([x for part in parts for x in part], dtype=object))

    def vector(self, kind: str, body: str) -> Array:
        """Coordinates, or velocities, of a body (7,)."""
        if body == GROUND:
            return STILL if kind == "q" else np.zeros_like(STILL)
        own = self.system.coordinates_of(body)
        return np.array([self.input(kind, n) for n in range(own.start, own.stop)], dtype=object)

    def input(self, kind: str, n: Any) -> Tracer:
        """Return one coordinate over time, one parameter, or a number that a mode has."""
        if (kind, n) not in self.inputs:
            self.inputs[kind, n] = self.tape.variable(self._value(kind, n))
        return self.inputs[kind, n]

    def _value(self, kind: str, n: Any) -> Any:
        if kind == "mode":
            return modal_value(self.about, *n)
        if kind == "linear":
            return linear_value(self.about, *n)
        if kind == "pole":
            return pole_value(self.about, *n)
        if kind == "b":
            return float(self._b[n])
        if kind == "c":
            return float(self.system.joint_coordinates.b[n])
        states = self.states.lam() if kind == "lam" else getattr(self.states, kind)
        return states[:, n]


class CurveOnTape:
    """A curve of an element as a function of a traced number; it depends on its own numbers, too."""

    def __init__(self, of: Recording, p: Population, k: int, place: int) -> None:
        self._of, self._at = of, (p, k, place)

    def __call__(self, x: Tracer) -> Tracer:
        return self._derivative(0, x)

    def slope(self, x: Tracer) -> Tracer:
        """Its first derivative."""
        return self._derivative(1, x)

    def bend(self, x: Tracer) -> Tracer:
        """Its second derivative."""
        return self._derivative(2, x)

    def moment(self, a: Any, b: Tracer) -> Tracer:
        """The integral from a to b of the curve times x - a."""
        begin = a if isinstance(a, Tracer) else self._of.constant(a)
        one, other = np.broadcast_arrays(np.atleast_1d(begin.value), np.atleast_1d(b.value))
        known, arm = CurveDerivatives(self._of.system), other - one
        area, found = (known.integral_of(*self._at, one, other, power) for power in (0, 1))
        at_one = known.of_curve(*self._at, 0, one)[0][0]
        (at_other, slope, _), numbers, (by, _) = known.of_curve(*self._at, 0, other)
        ends = dict(zip(numbers, by, strict=True))
        by_one, by_other = [-x for x in area.by], [arm * ends.get(n, 0.0) for n in found.numbers]

        def second() -> list[list[Any]]:
            return _or_zero(known.second_integral_of(*self._at, one, other), len(found.numbers))

        law = Operation(
            lambda *_: found.value,
            lambda *_: (-area.value, arm * at_other, *found.by),
            lambda *_: (
                (at_one, -at_other, *by_one),
                (-at_other, arm * slope + at_other, *by_other),
                *((x, y, *row) for x, y, row in zip(by_one, by_other, second(), strict=True)),
            ),
        )
        places = (self._of.input("b", n).at for n in found.numbers)
        return b.tape.add(law, (begin.at, b.at, *places), found.value)

    def _derivative(self, order: int, x: Tracer) -> Tracer:
        known, at = CurveDerivatives(self._of.system), np.atleast_1d(x.value)
        (value, slope, bend), numbers, (by, slope_by) = known.of_curve(*self._at, order, at)

        def second() -> list[list[Any]]:
            return _or_zero(known.second_of(*self._at, order, at), len(numbers))

        law = Operation(
            lambda *_: value,
            lambda *_: (slope, *by),
            lambda *_: (
                (bend, *slope_by),
                *((one, *row) for one, row in zip(slope_by, second(), strict=True)),
            ),
        )
        places = (self._of.input("b", n).at for n in numbers)
        return x.tape.add(law, (x.at, *places), value)


class SurfaceOnTape:
    """A surface of an element as a function of two traced numbers."""

    def __init__(self, of: Recording, p: Population, k: int, place: int) -> None:
        index = next(m for m, n in tables_of(p.kind, "Surface") if n == place)
        self._of, self._surface = of, p.values[k][index]

    def __call__(self, x: Any, y: Any) -> Tracer:
        return self.derivative(x, y, 0, 0)

    def derivative(self, x: Any, y: Any, i: int, j: int) -> Tracer:
        """∂ⁱ⁺ʲz/∂xⁱ∂yʲ."""
        traced = [one if isinstance(one, Tracer) else self._of.constant(one) for one in (x, y)]
        places = [np.atleast_1d(one.value) for one in traced]

        def of(m: int, n: int) -> Array:
            return np.asarray(self._surface.derivative(*places, i + m, j + n))

        value = of(0, 0)
        law = Operation(
            lambda *_: value,
            lambda *_: (of(1, 0), of(0, 1)),
            lambda *_: ((of(2, 0), of(1, 1)), (of(1, 1), of(0, 2))),
        )
        return traced[0].tape.add(law, tuple(one.at for one in traced), value)


ON_TAPE: dict[str, Any] = {"Curve": CurveOnTape, "Surface": SurfaceOnTape}


def _or_zero(rows: list[list[Any]], count: int) -> list[list[Any]]:
    """Second derivatives by parameters; zero where none are given, of what is linear in them."""
    return rows or [[0.0] * count] * count


def _held(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """A function whose derivative is zero."""

    def held(x: Any) -> Any:
        found = function(np.asarray(value_of(x)))
        return x.tape.add("constant", (), found) if isinstance(x, Tracer) else found

    return held


TRACED: dict[str, Callable[..., Any]] = ARRAYS | {name: _held(MANY[name]) for name in ("nearest", "positive")}


def modal_value(modes: Any, at: int, word: str | int) -> float:
    """The real or imaginary part of an eigenvalue, ``re``, ``im``; of a place, the real part of the shape there.

    Raises
    ------
    UnknownOutput
        If the result has no such mode.
    """
    if not hasattr(modes, "eigenvalues"):
        raise UnknownOutput(f"mode{at + 1}: this result has no modes. Use sr.modes, in studies Vibration().")
    count = len(modes.eigenvalues)
    if at >= count:
        choice = f"Choose mode1{f' to mode{count}' * (count > 1)}"
        remedy = f"{choice if count else 'The system has no degrees of freedom'}."
        raise SarrusError(f"{modes.name} has no mode{at + 1}. {remedy}")
    if isinstance(word, int):
        return float(modes.shapes[word, at].real)
    return float(getattr(modes.eigenvalues[at], {"re": "real", "im": "imag"}[word]))


def pole_value(plant: Any, at: int, part: str) -> float:
    """The real or imaginary part of a pole, ``re``, ``im``.

    Raises
    ------
    UnknownOutput
        If the result has no matrices.
    """
    _refuse_no_matrices(plant, f"pole{at + 1}")
    return float(getattr(plant.pole(at + 1).value, {"re": "real", "im": "imag"}[part]))


def linear_value(plant: Any, word: str, row: str, column: str, frequency: float | None = None) -> float:
    """An entry of a matrix of a linearization, or the real or imaginary part of a frequency response.

    Raises
    ------
    UnknownOutput
        If the result has no matrices.
    SarrusError
        At a pole.
    """
    _refuse_no_matrices(plant, f"{word}[{row}, {column}{'' if frequency is None else f', {frequency:g}'}]")
    if frequency is None:
        return float(getattr(plant, word)[plant.place(word, row, column)])
    try:
        found = plant.transfer(2j * np.pi * frequency)[plant.place("D", row, column)]
    except np.linalg.LinAlgError:
        raise SarrusError(
            f"{plant.name}: {frequency:g} Hz is a pole of the linearization. Choose another frequency."
        ) from None
    return float(getattr(found, {"real": "real", "imaginary": "imag"}[word]))


def _refuse_no_matrices(plant: Any, name: str) -> None:
    if not hasattr(plant, "transfer"):
        raise UnknownOutput(
            f"{name}: this result has no matrices. Use sr.linearize, in studies Linearization()."
        )


def members_of(p: Population, owner: str) -> list[int]:
    """Return the elements of a part of the model."""
    return [k for k, name in enumerate(p.owners) if name == owner]
