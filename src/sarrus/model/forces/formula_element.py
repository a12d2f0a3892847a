"""The element of a force by formulas of outputs: one class for each structure of formulas, created when needed.

    Q = Σ_k F_k(y, t) · (Q of a unit load k),    y: outputs of the mechanism

The unit loads are those of other elements: a tension, a force at a point, a torque, a constraint force along a joint's
coordinate. All derivatives are made by differentiating what is recorded.
"""

from __future__ import annotations

import copyreg
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar, NamedTuple, Protocol, TypeAlias
from unicodedata import normalize

import numpy as np

from ... import elements
from ..._jit.formulas.expression import Expression as Recorded
from ...algebra import Array, Row, total
from ...elements import Element, Pair, Single, output
from ...elements.element import Scalar, Vec3
from ..laws.recorded import Operations, Recording
from ..primitive import Primitive
from ..signals import Measure, MeasureClass, Signal

Values: TypeAlias = Any  # of the laws
MOST_CLASSES = 1000


@dataclass(frozen=True)
class Line:
    """The line between a point of body i and one of body j, with a force that pushes them apart."""

    fields: ClassVar[dict[str, str]] = {"s_i": "Vec3", "s_j": "Vec3"}
    bodies: ClassVar[int] = 2

    s_i: Vec3  # [m] P_i in body i
    s_j: Vec3  # [m] P_j in body j

    def length(self, x: Pair) -> Scalar:
        """Distance of the points [m]."""
        return self._actuator(0).present_length(x)

    def rate(self, x: Pair, v: Pair) -> Scalar:
        """Its rate [m/s]."""
        return self._actuator(0).rate(x, v)

    def act(self, values: Values, x: Pair, v: Pair, t: Scalar) -> Row:
        """Q of a force along the line, positive where it pushes."""
        return self._actuator(-values[0]).Q(x, v, t)

    def _actuator(self, tension: Scalar) -> elements.TSDA:
        return elements.TSDA(self.s_i, self.s_j, 0, 0, 0, tension)


class LoadFunction(Protocol):
    """Q of a load, by the functions of its measure, the values of the laws, coordinates, rates and time."""

    def __call__(self, of: Any, values: Values, x: Any, v: Any, t: Any, /) -> Row: ...


class ConstraintRows(Protocol):
    """Equations in place of a load: the base of the element's class, and how many there are."""

    @property
    def base(self) -> type[OutputLaws]:
        """The base of the class."""

    @property
    def rows(self) -> int:
        """Number of equations."""


class InertiaKind(Protocol):
    """An inertia in place of a load: the base of the element's class."""

    @property
    def base(self) -> type[OutputLaws]:
        """The base of the class."""


class Target(NamedTuple):
    """Load of the laws: a measure, and the Q of the laws' values on it."""

    measure: Measure
    act: LoadFunction | ConstraintRows


def along_coordinate(of: Any, values: Values, x: Any, v: Any, t: Scalar) -> Row:
    """Q of a generalized force along the coordinate that a constraint element measures: F θ_qᵀ."""
    return tuple(of.Phi_qT_lam(x, np.array([values[0]])))


def along_line(of: Line, values: Values, x: Pair, v: Pair, t: Scalar) -> Row:
    """Q of a force between two points."""
    return of.act(values, x, v, t)


@dataclass(frozen=True)
class Spot:
    """A point of a body, with a force in global axes."""

    fields: ClassVar[dict[str, str]] = {"s": "Vec3"}
    bodies: ClassVar[int] = 1

    s: Vec3  # [m] in the body


@dataclass(frozen=True)
class WholeBody:
    """A body, with a torque."""

    fields: ClassVar[dict[str, str]] = {}
    bodies: ClassVar[int] = 1


def global_force(of: Spot, values: Values, x: Single, v: Single, t: Scalar) -> Row:
    """Q of a force at a point, in global axes."""
    return elements.PointForce(of.s, np.array(values)).Q(x, v, t)


def body_force(of: Spot, values: Values, x: Single, v: Single, t: Scalar) -> Row:
    """Q of a force at a point, in body axes."""
    return elements.FollowerForce(of.s, np.array(values)).Q(x, v, t)


def global_torque(of: WholeBody, values: Values, x: Single, v: Single, t: Scalar) -> Row:
    """Q of a torque in global axes."""
    return elements.Torque(np.array(values)).Q(x, v, t)


def body_torque(of: WholeBody, values: Values, x: Single, v: Single, t: Scalar) -> Row:
    """Q of a torque in body axes."""
    return elements.BodyTorque(np.array(values)).Q(x, v, t)


class Part(NamedTuple):
    """A measure in an element: its class, the places of its bodies among the element's, its first field's number."""

    kind: MeasureClass
    places: tuple[int, ...]


class Structure(NamedTuple):
    """All that the class of an element depends on: not the numbers, nor which bodies."""

    act: LoadFunction | ConstraintRows | InertiaKind | None  # none of a constraint by one law
    parts: tuple[Part, ...]  # the last is the one that is loaded
    signals: tuple[tuple[int, str, int, int], ...]  # part, method, arguments, component
    operations: Operations
    numbers: tuple[str, ...]  # names of the fields of numbers
    curves: int
    bodies: int
    unit: str  # of the value, or none for vectors


def load_primitive(
    target: Target, laws: list[Recorded], recording: Recording, signals: Sequence[Signal], unit: str = ""
) -> Primitive:
    """Return the primitive of a load by formulas.

    Parameters
    ----------
    target
        What is loaded.
    laws, recording
        The laws, and the recording that they are on.
    signals
        Those of the recording, once the laws are on it.
    unit
        Of a single value, which is an output then.
    """
    measures = list(dict.fromkeys([*(one.measure for one in signals if one.measure != target.measure)]))
    measures.append(target.measure)
    names = list(dict.fromkeys(body for one in measures[:-1] for body in one.bodies))
    bodies = [body for body in names if body not in target.measure.bodies]
    bodies += dict.fromkeys(target.measure.bodies)
    parts = tuple(Part(one.kind, tuple(bodies.index(body) for body in one.bodies)) for one in measures)
    return _primitive(target.act, measures, parts, bodies, laws, recording, signals, unit)


def constraint_primitive(law: Recorded, recording: Recording, signals: Sequence[Signal]) -> Primitive:
    """Return the primitive of the equation law = 0, whose signals are positions. Each measure has its own bodies."""
    measures = list(dict.fromkeys(one.measure for one in signals))
    bodies = [body for one in measures for body in one.bodies]
    ends = np.cumsum([0, *(len(one.bodies) for one in measures)]).tolist()
    parts = tuple(Part(one.kind, tuple(range(*ends[n : n + 2]))) for n, one in enumerate(measures))
    found = _primitive(None, measures, parts, bodies, [law], recording, signals, "")
    return found._replace(label="equation")


def inertia_primitive(
    kind: InertiaKind, measure: Measure, numbers: list[Recorded], recording: Recording
) -> Primitive:
    """Return the primitive of an inertia of a measure, by numbers of a recording."""
    bodies = list(dict.fromkeys(measure.bodies))
    part = Part(measure.kind, tuple(bodies.index(body) for body in measure.bodies))
    found = _primitive(kind, [measure], (part,), bodies, numbers, recording, (), "")
    return found._replace(label="inertia")


def _primitive(
    act: LoadFunction | ConstraintRows | InertiaKind | None,
    measures: list[Measure],
    parts: tuple[Part, ...],
    bodies: list[str],
    laws: list[Recorded],
    recording: Recording,
    signals: Sequence[Signal],
    unit: str,
) -> Primitive:
    places = tuple((measures.index(one.measure), *one[1:4]) for one in signals)
    operations, labels, curves = recording.operations(laws), _labels(recording.labels), recording.curves
    structure = Structure(act, parts, places, operations, labels, len(curves), len(bodies), unit)
    values = [value for one in measures for value in one.values] + [*recording.numbers, *curves]
    return Primitive(_element_class(structure), tuple(bodies), tuple(values), "load")


def _labels(names: Sequence[str]) -> tuple[str, ...]:
    """Return a field's name for each number, other than those of measures, ``s_i_0``, and of tables, ``curve0``.

    Python takes some letters of names for equal, as both kinds of µ.
    """
    own = [normalize("NFKC", name) for name in names]
    return tuple(
        f"{name}_" if name.isidentifier() and own.count(name) == 1 else f"number{n}"
        for n, name in enumerate(own, 1)
    )


class LoadType(type):
    """Type of the classes of loads, which are pickled by their structure."""


class OutputLaws(metaclass=LoadType):
    """Laws of measures, which are the fields of an element."""

    structure: ClassVar[Structure]

    def _measures(self) -> list[Any]:
        """The elements that measure signals; the last one is loaded."""
        return [
            part.kind(*(getattr(self, f"{field}_{n}") for field in part.kind.fields))
            for n, part in enumerate(self.structure.parts)
        ]

    def loaded(self) -> Any:
        """The measure that is loaded."""
        return self._measures()[-1]

    def _local(self, n: int, x: Any) -> Any:
        """Coordinates, or rates, of the bodies of a measure."""
        blocks = [block for place in self.structure.parts[n].places for block in x[2 * place : 2 * place + 2]]
        kinds: dict[int, Any] = {2: Single, 4: Pair}
        return kinds[len(blocks)](*blocks) if len(blocks) in kinds else tuple(blocks)

    def signals(self, x: Any, v: Any, t: Scalar) -> list[Any]:
        """The outputs that the laws depend on."""
        found, measures = [], self._measures()
        for part, method, arguments, component in self.structure.signals:
            given = (self._local(part, x), self._local(part, v), t)[:arguments]
            found.append(np.ravel(getattr(measures[part], method)(*given))[component])
        return found

    def values(self, x: Any, v: Any, t: Scalar) -> list[Any]:
        """The values of the laws."""
        own = self.structure
        numbers = [getattr(self, name) for name in own.numbers]
        curves = [getattr(self, f"curve{n}") for n in range(own.curves)]
        return own.operations.values(self.signals(x, v, t), numbers, curves, t)

    def remember(self, x: Any) -> tuple[Scalar, ...]:
        """New values of the memory fields of all measures at an accepted state."""
        found: list[Scalar] = []
        for n, measure in enumerate(self._measures()):
            if "Memory" in measure.fields.values():
                found += measure.remember(self._local(n, x))
        return tuple(found)


class FormulaLoad(OutputLaws, elements.Force, abstract=True):
    """Base of the classes of loads by formulas."""

    def Q(self, x: Any, v: Any, t: Scalar) -> Row:
        last = len(self.structure.parts) - 1
        given = self.values(x, v, t), self._local(last, x), self._local(last, v), t
        blocks: list[Any] = [None] * (2 * self.structure.bodies)
        act = self.structure.act
        assert callable(act)  # of a load
        acted = act(self.loaded(), *given)
        for n, place in enumerate(self.structure.parts[last].places):
            for m in (0, 1):
                blocks[2 * place + m] = total((blocks[2 * place + m], acted[2 * n + m]))
        return tuple(blocks)


class FormulaConstraint(OutputLaws, elements.Primitive, abstract=True):
    """Base of the classes of constraints by formulas: Φ is the value of a law of positions."""

    def Phi(self, x: Any) -> Array:
        return np.array(self.values(x, x, 0))

    def gradient(self, x: Any) -> Array:
        """Φ_q as one vector, for reactions."""
        pairs: Any = zip(self.Phi_q(x), self.coordinates(), strict=True)
        rows = [np.zeros(width, dtype=object) if row is None else np.ravel(row) for row, width in pairs]
        return np.concatenate(rows)


@lru_cache(MOST_CLASSES)
def _element_class(structure: Structure) -> type[Element]:
    """The class of a structure: fields are those of its measures, then numbers and curves."""
    fields = {
        f"{field}_{n}": kind
        for n, part in enumerate(structure.parts)
        for field, kind in part.kind.fields.items()
    }
    fields |= dict.fromkeys(structure.numbers, "Scalar")
    fields |= {f"curve{n}": "Curve" for n in range(structure.curves)}
    load = getattr(structure.parts[-1].kind, "load", FormulaLoad)
    base: type = FormulaConstraint if structure.act is None else getattr(structure.act, "base", load)
    fields |= getattr(base, "own_fields", {})
    body: dict[str, Any] = {"__annotations__": fields, "__module__": __name__, "structure": structure}
    body |= _outputs(structure)
    if "Memory" not in fields.values():
        body["remember"] = None
    options: dict[str, Any] = {"derivatives": "automatic", "rare": True, "registered": False}
    if issubclass(base, elements.Primitive):
        options["rows"] = getattr(structure.act, "rows", 1)
    made: Any = LoadType("Load", (base,), body, bodies=structure.bodies, **options)
    found: type[Element] = made
    return found


def _reduced(kind: Any) -> Any:
    """Return the pickled form of a class of loads."""
    return kind.__qualname__ if "structure" not in vars(kind) else (_element_class, (kind.structure,))


copyreg.pickle(LoadType, _reduced)


def _law(n: int, word: str, unit: str) -> Any:
    """Return the output method of the n-th law."""

    def law(self: Any, x: Any, v: Any, t: Scalar) -> Scalar:
        """The value of a law."""
        return self.values(x, v, t)[n]

    law.__name__ = f"law_{word}"
    return output(unit, word)(law)


def _outputs(structure: Structure) -> dict[str, Any]:
    """The outputs of a class: the value, and what it acts along."""
    found: dict[str, Any] = {}
    last = len(structure.parts) - 1
    if structure.unit:

        @output(structure.unit, getattr(structure.parts[last].kind, "word", "value"))
        def law_value(self: Any, x: Any, v: Any, t: Scalar) -> Scalar:
            """The value of the law."""
            return self.values(x, v, t)[0]

        found["law_value"] = law_value
    further = getattr(structure.act, "outputs", ())
    for n, (word, unit) in enumerate(further, len(structure.operations.results) - len(further)):
        found[f"law_{word}"] = _law(n, word, unit)
    if structure.parts[last].kind is Line:

        @output("m")
        def length(self: Any, x: Any) -> Scalar:
            """Distance of its points."""
            return self.loaded().length(self._local(last, x))

        @output("m/s")
        def rate(self: Any, x: Any, v: Any) -> Scalar:
            """Rate of the distance."""
            return self.loaded().rate(self._local(last, x), self._local(last, v))

        found |= {"length": length, "rate": rate}
    return found
