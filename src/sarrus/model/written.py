"""Every number that a person wrote into a model, by name; and the same model with other numbers in their places.

Names follow the fields: ``rod.mass``, ``rod.inertia.xx``, ``pin.point.x``, ``spring.point_i.z``, ``hinge.frame_i.x.y``,
``crank.orientation.e1``, ``gravity.z``, ``rates.pin``. In a table they are the values, ``motor.motion.2.y`` in its
second row, in a formula its numbers one after another, ``motor.motion.1``. Names of other parts and Python functions
are no numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from .bodies.shape import Shape
from .checks.arguments import in_si
from .checks.findings import Path
from .errors import ModelError
from .expression import Expression, Number
from .geometry.points import Point, Solid
from .laws.curve import Curve, Formula
from .laws.jumps import names_in_jumps
from .laws.recorded import parsed
from .laws.surface import Surface
from .measure import matrix_fields, measures_of
from .quantity import ROUND_OFF, is_list, number
from .show import quote, suggest
from .tape import Tracer

if TYPE_CHECKING:
    from .model import Model

Steps: TypeAlias = tuple[str | int, ...]
Change: TypeAlias = Callable[[Steps, Any], Any]
EULER = ("e0", "e1", "e2", "e3")
LABELS: dict[str, tuple[str, ...]] = {
    "inertia": ("xx", "yy", "zz"),
    "orientation": EULER,
    "initial_orientation": EULER,
}
AXES = ("x", "y", "z")
# Fields whose entries have numbers: of forces and torques, of linear systems, points of paths
NUMBERED = {
    "stiffness",
    "damping",
    "preload",
    "numerator",
    "denominator",
    *"ABCD",
    "inputs",
    "initial",
    "path",
}
NAMES = 20_000  # that are remembered: a model is looked through several times for every design
GRAVITY, RATES = "gravity", "rates"  # of a model, not of its parts
DEFINING = ("parameters", "points")  # sections of a file whose numbers are no numbers of parts


def written_numbers(model: Model) -> dict[str, float]:
    """Return every number of the model by name, in the model's order.

    A centre of mass and a gravity of zeros are left out: they are no part of the equations of motion. So are those that
    a part names in ``absent_numbers``, because its equations have other terms where they are zero or missing.
    """
    numbers: dict[str, float] = {}

    def note(steps: Steps, value: Any) -> Any:
        numbers[named(steps)] = float(value)
        return value

    exchanged(model, note)
    return numbers


def exchanged(model: Model, change: Change) -> Model:
    """Return the model with ``change(steps, number)`` in the place of every number."""
    parts = {
        section: [_part(part, change) for part in section_parts]
        for section, section_parts in model.sections().items()
    }
    gravity = _value(model.gravity, (GRAVITY,), change) if any(model.gravity) else model.gravity
    rates = _value(model.rates, (RATES,), change)
    return replace(model, gravity=gravity, rates=rates, **parts)  # type: ignore[arg-type]


def with_numbers(model: Model, numbers: Mapping[str, Any]) -> Model:
    """Return the model with other numbers in the places that are named."""
    return exchanged(model, lambda steps, value: numbers.get(named(steps), value))


def with_parameters(model: Model, values: Mapping[str, float | str]) -> Model:
    """Return the model with other values of parameters; see `Model.with_parameters`."""
    known = [*model.parameters, *written_numbers(model)]
    for name in values:
        if name not in known:
            raise ModelError(f"there is no parameter {quote(name)}. {suggest(name, known)}", part="model")
    new = {
        name: number(in_si(name, value, _unit(model, name)), name, "Give a number in SI units.")
        for name, value in values.items()
    }
    own = {name: value for name, value in new.items() if name in model.parameters}
    changed = replace(model, formulas=model.formulas.with_values(own)) if own else model
    others = {name: value for name, value in new.items() if name not in own}
    return with_numbers(changed, following_numbers(model, own) | others)


def _unit(model: Model, name: str) -> str | None:
    """The SI unit of a parameter for a text such as "271 mm"; None if any unit may be meant."""
    owner, _, rest = name.partition(".")
    if owner in model.hardpoints:
        return "m"
    parts = (part for section in model.sections().values() for part in section if part.name == owner)
    measures = measures_of(next(parts, None))
    return measures[rest].unit or None if rest in measures else None


def following_numbers(model: Model, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers of parts that follow from parameters, by name, for values of any kind of these.

    A number that has another value than its formula, as one of a part that was replaced, no longer follows, nor does
    one of a part that was removed.
    """
    formulas = model.formulas
    if not given:
        return {}
    values, moving = formulas.values(given), formulas.following(given)
    present, written, sections = formulas.values(), written_numbers(model), model.sections()
    parts = {part.name for section in sections.values() for part in section}
    return {
        name: values[parameter] for name, parameter in in_functions(model).items() if parameter in moving
    } | {
        name: tree.value(values)
        for path, tree in formulas.expressions.items()
        if path[0] not in DEFINING
        and (path[0] not in sections or path[1] in parts)
        and moving.intersection(tree.names())
        and _has_value(written.get(name := named(steps_of(path))), tree, present)
    }


def _has_value(number: float | None, tree: Expression, values: Mapping[str, Any]) -> bool:
    """Whether a number, if there is one, is that of its formula, except for round-off."""
    if number is None:
        return True
    found = float(tree.value(values))
    largest = max(abs(x) for x in (number, found, *(float(values[name]) for name in tree.names())))
    return abs(found - number) <= ROUND_OFF * largest


@lru_cache(NAMES)
def named(steps: Steps) -> str:
    """Return the name of a number: ``pin.point.x`` of the steps (pin, point, 0)."""
    return ".".join(_step(steps, n) for n in range(len(steps)))


def steps_of(path: Path) -> Steps:
    """Return the steps to the number at a path of a model file, (forces, spring, points, 0, at, 2)."""
    if path[0] in (GRAVITY, RATES):
        return path
    steps: list[str | int] = [path[1]]
    rest = list(path[2:])
    while rest:
        step = rest.pop(0)
        if step in ("points", "frames", "bodies") and rest and isinstance(rest[0], int):
            steps.append(f"{str(step)[:-1]}_{'ij'[int(rest.pop(0))]}")
        elif step in ("at", "global"):
            steps += ["point"] if str(steps[-1]).startswith(("frame", "plane")) else []
        elif step == "table":
            steps += [str(int(rest.pop(0)) + 1), "xy"[int(rest.pop(0))]] if len(rest) > 1 else []
        else:
            steps.append(step)
    return tuple(steps)


def _part(part: Any, change: Change) -> Any:
    laws = _laws(part)
    absent = {(part.name, *steps) for steps in getattr(part, "absent_numbers", ())}
    matrices = matrix_fields(part.__class__)

    def changed(steps: Steps, value: Any) -> Any:
        return value if steps in absent else change(steps, value)

    new = {
        name: _value(
            getattr(part, name), (part.name, name), changed, name in laws, tables=name not in matrices
        )
        for name in (field.name for field in fields(part))
        if name != "name"
    }
    if "center_of_mass" in new and (part.center_of_mass is None or not any(part.center_of_mass)):
        new["center_of_mass"] = part.center_of_mass
    return replace(part, **new)


def _laws(part: Any) -> set[str]:
    """The fields of a part that may have formulas."""
    return {name for name, measure in measures_of(part).items() if measure.over != "1" or measure.outputs}


def _value(value: Any, steps: Steps, change: Change, law: bool = False, tables: bool = True) -> Any:
    """A field's value with its numbers changed; in a law, a text is a formula, and pairs are a table."""
    if isinstance(value, str) and law:
        value = parsed(value, str(steps[1]))
    if isinstance(value, bool | str | Solid | Shape | Surface) or value is None:
        return value
    if isinstance(value, Curve):
        if not value.pairs:
            return value
        pairs = _value(value.pairs[: len(value.pairs) - value.periodic], steps, change)
        closing = [(value.pairs[-1][0], pairs[0][1])] * value.periodic  # no number of its own
        return Curve.table([*pairs, *closing], periodic=value.periodic)
    if isinstance(value, Expression | Formula):
        return value.exchanged(
            lambda n, number: _changed(number, change((*steps, str(n + 1)), _traced(number)))
        )
    if isinstance(value, int | float | np.number | Tracer):
        return change(steps, value)
    if isinstance(value, Point):
        return replace(value, coordinates=_value(value.coordinates, steps, change))
    if is_dataclass(value) and not isinstance(value, type):
        own = [field.name for field in fields(value) if field.init]
        return replace(value, **{n: _value(getattr(value, n), (*steps, n), change) for n in own})
    if isinstance(value, Mapping):
        return {key: _value(entry, (*steps, key), change) for key, entry in value.items()}
    if is_list(value) and not (tables and _is_table(value)):
        return [_value(entry, (*steps, n), change, law, tables) for n, entry in enumerate(value)]
    if is_list(value):
        return [[x, change((*steps, str(n + 1), "y"), y)] for n, (x, y) in enumerate(value)]
    return value


def _changed(number: Number, new: Any) -> Number:
    """A constant of a formula with another value, whose text is then no longer the one that was written."""
    same = not isinstance(new, Tracer) and float(new) == number.number
    return number if same else replace(number, number=new, written="")


class NumberOfFile(float):
    """The number that a parameter of a model file has in a function."""

    of: str


def _traced(number: Number) -> Any:
    """A constant of a formula, marked with the parameter whose value it is."""
    if not number.of:
        return number.number
    found = NumberOfFile(number.number)
    found.of = number.of
    return found


def in_functions(model: Model) -> dict[str, str]:
    """Return the numbers in functions that are parameters of the model file, with the parameters' names."""
    names: dict[str, str] = {}

    def note(steps: Steps, value: Any) -> Any:
        if isinstance(value, NumberOfFile):
            names[named(steps)] = value.of
        return value

    exchanged(model, note)
    return names


def numbers_in_jumps(model: Model) -> frozenset[str]:
    """Return the numbers in arguments of `sign` and of `step` of one argument, by name: they move a jump."""
    found: set[str] = set()
    for part in (part for parts in model.sections().values() for part in parts):
        parameters = getattr(part, "parameters", None) or {}
        for field in _laws(part):
            for steps, tree in _trees(getattr(part, field, None), (part.name, field)):
                for name in names_in_jumps(tree):
                    if name[0] == "#":
                        found.add(named((*steps, name[1:])))
                    elif name in parameters:
                        found.add(named((part.name, "parameters", name)))
    return frozenset(found)


def _trees(value: Any, steps: Steps) -> Iterator[tuple[Steps, Expression]]:
    """Yield the formulas of a law, or of several in a list, with the steps to them."""
    if isinstance(value, str):
        value = parsed(value, str(steps[1]))
    if isinstance(value, Formula) and value.written:
        value = value.written.tree
    if isinstance(value, Expression):
        yield steps, value
    if is_list(value):
        for n, one in enumerate(value):
            yield from _trees(one, (*steps, n))


def _is_table(value: Any) -> bool:
    """Whether these are pairs of a table."""
    return all(is_list(row) and len(row) == 2 and isinstance(row[0], int | float) for row in value)


def _step(steps: Steps, n: int) -> str:
    step = steps[n]
    if not isinstance(step, int):
        return step
    before = str(steps[n - 1])
    if before == "inertia" and len(steps) == n + 2:
        return AXES[step]
    labels = () if steps[1] in NUMBERED or before == "around" else LABELS.get(before, AXES)
    return labels[step] if step < len(labels) else str(step + 1)
