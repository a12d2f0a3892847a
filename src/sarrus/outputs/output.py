"""Outputs, their providers, and the search of an output by its name."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from difflib import get_close_matches
from enum import IntEnum
from functools import partial
from typing import TYPE_CHECKING, Any

from ..model import ModelError, SarrusError
from ..model.expansion.blueprint import Placement
from ..model.expression import Expression, Name, parse
from ..model.forces.formula_element import constraint_primitive
from ..model.geometry.points import GROUND
from ..model.laws.recorded import Recording
from ..model.show import suggest
from ..model.signals import Measure, Signal, part_of
from ..model.written import written_numbers
from ..system import System
from ..system.cached import once
from .reductions import REDUCTIONS, is_reduction
from .units import refuse_other_units, unit_of_parameter, unit_of_tree

if TYPE_CHECKING:
    from ..algebra import Array
    from ..model.tape import Tracer
    from .outputs import Outputs

POINT = re.compile(r"(?P<body>[^()]+)\((?P<place>[^()]*)\)(?P<rest>.*)")
ENTRY = re.compile(r"(?P<word>[A-D]|magnitude|phase|real|imaginary)\[(?P<names>[^\[\]]*)\]")
OPERATORS = re.compile(r"[-+*/^(]")
NAME = re.compile(r"(?:[^(),]|\([^()]*\))+")  # between commas outside of brackets


class Level(IntEnum):
    """Quantities on which an output depends, besides the time and parameters."""

    POSITION = 0
    VELOCITY = 1
    ACCELERATION = 2  # accelerations, multipliers
    HISTORY = 3  # the motion since the start


DEPENDS_ON = {
    Level.VELOCITY: "velocities",
    Level.ACCELERATION: "accelerations or reactions",
    Level.HISTORY: "the motion since the start",
}


@dataclass(frozen=True, eq=False)
class Output:
    """A number that a system has at every time.

    Attributes
    ----------
    name, unit : ``spring.tension`` and N
    record : its value along a motion, of `Outputs`
    level : what it depends on
    place : of a coordinate, its place in q
    element : of a function of the position, the element that measures it, where there is one
    rate : of an integral since the start, the name of the output that is integrated
    only : the kind of result that alone has it, "modes" or "linearization"; empty for all
    """

    name: str
    unit: str
    record: Callable[[Outputs], Tracer | Array | float]
    level: Level = Level.POSITION
    place: int | None = None
    element: Callable[[System], Placement] | None = None
    rate: str = ""
    only: str = ""

    @property
    def label(self) -> str:
        """The name with the unit, for axes and columns."""
        return labelled(self.name, self.unit)


def labelled(name: str, unit: str) -> str:
    """A name with its unit, for axes and columns."""
    return f"{name} [{unit}]" if unit else name


class UnknownOutput(SarrusError, KeyError):
    """An output that the system does not have, or that cannot be used where it is named."""

    __str__ = Exception.__str__


Provider = Callable[[System, str | None], Iterable[Output]]
PROVIDERS: list[Provider] = []


def provides(provider: Provider) -> Provider:
    """Register a function ``f(system, part)`` that yields the outputs of one part of a system, or of all for None.

    The part is what is before the first point of a name.
    """
    PROVIDERS.append(provider)
    return provider


def outputs_of(system: System, part: str | None = None) -> Iterator[Output]:
    """All outputs of a system, or those of one part."""
    return (output for provider in PROVIDERS for output in provider(system, part))


@once
def _of_part(system: System, part: str, providers: int) -> dict[str, Output]:
    """The outputs of a part by name, for so many providers."""
    return {one.name: one for one in outputs_of(system, part)}


def calls(method: str, *args: Any, at: int | None = None, **options: Any) -> Callable[[Any], Any]:
    """Return the record of an output from a method of `Outputs`, or one component of it."""

    def record(o: Any) -> Any:
        found = getattr(o, method)(*args, **options)
        return found if at is None else found[at]

    return record


def among(names: Iterable[str], part: str | None) -> list[str]:
    """All names, or the one that is asked for."""
    return [name for name in names if part in (None, name)]


@provides
def named(system: System, part: str | None) -> Iterator[Output]:
    """The outputs that the model names."""
    for name, text in system.model.outputs.items():
        if part in (None, part_of(name)):
            try:
                yield replace(find_output(system, text), name=name)
            except UnknownOutput as wrong:
                raise UnknownOutput(f"outputs: {name}: {wrong}") from None


@once
def parameters_of(system: System) -> dict[str, float]:
    """The parameters of a model, and those of its file."""
    return {**written_numbers(system.model), **system.model.parameters}


def formula_of(system: System, text: str) -> Expression:
    """A formula of outputs and parameters, with their formulas in the place of outputs that the model names.

    Raises
    ------
    UnknownOutput
        For a text that is no formula, or one number of a whole run.
    """
    tree, named = _parsed(text), system.model.outputs
    while own := [name for name in tree.names() if name in named]:
        tree = tree.replaced({name: _parsed(named[name]) for name in own})
    return tree


def _parsed(text: str) -> Expression:
    try:
        tree = parse(text, functions=REDUCTIONS)
    except ModelError as wrong:
        raise UnknownOutput(f"the output {text!r} {wrong.message}") from None
    if reduced := next(filter(is_reduction, tree.nodes()), None):
        raise UnknownOutput(
            f"{reduced} is one number of a whole run, not an output at each time. Use {text!r} as a response."
        )
    return tree


@once
def _of_formula(system: System, text: str) -> Output:
    """The output of a formula of other outputs and of parameters."""
    tree = formula_of(system, text)
    if isinstance(tree, Name):  # quoted, or between spaces
        if tree.name == text:
            raise UnknownOutput(text)
        return find_output(system, tree.name)
    names = tree.names()
    parts = {name: find_output(system, name) for name in names}
    units = {name: one.unit for name, one in parts.items()}
    try:
        refuse_other_units(tree, units)
    except ModelError as wrong:
        message = wrong.message.removesuffix("Convert one of them.")
        remedy = "Multiply one of them by a number, which may have any unit."
        raise UnknownOutput(f"{system.name}: the output {text!r} {message}{remedy}") from None
    measured = parts and all(one.element or name in parameters_of(system) for name, one in parts.items())
    return Output(
        text.strip(),
        unit_of_tree(tree, units),
        lambda o: tree.value({name: o(name) for name in names}),
        max((one.level for one in parts.values()), default=Level.POSITION),
        element=partial(_element, text) if measured else None,
        only=next((one.only for one in parts.values() if one.only), ""),
    )


def _element(text: str, system: System) -> Placement:
    """The element that measures a formula of positions: a constraint by a formula."""
    recording, names = Recording(text, {}, parameters_of(system)), (GROUND, *system.bodies)
    law, signals = recording.law(formula_of(system, text)), list[Signal]()
    for name in recording.signals:
        of: Any = find_output(system, name).element
        element, bodies, values, *_ = of(system)
        signals.append(Signal(Measure(element, tuple(names[n] for n in bodies), values), "Phi", 1, 0, ""))
    found = constraint_primitive(law, recording, signals)
    if "Memory" in found.element.fields.values():
        raise UnknownOutput(
            f"{system.name}: {text!r} contains an angle, which counts revolutions. Name the angle alone here."
        )
    return Placement(found.element, tuple(map(names.index, found.bodies)), found.values, text, found.label)


def find_output(system: System, name: str, most: Level = Level.HISTORY, where: str = "") -> Output:
    """The output of a name, or of a formula of outputs and parameters, ``slider.x - 2*crank.y``.

    Parameters
    ----------
    most : what it may depend on
    where : who asks, for messages: "a workspace"

    Raises
    ------
    UnknownOutput
        If there is none, with the nearest name; or if it depends on more.
    """
    given: object = name
    if not isinstance(given, str):
        several = "the names one by one, as in plot('slider.x', 'rod.x'), or with a star, plot(*names)"
        remedy = several if isinstance(given, list | tuple) else "one such as 'slider.x'"
        raise TypeError(f"output: it must be a name, got {given!r:.60}. Give {remedy}.")
    full = _spelt(name)
    part, found = _part_of(system, full)
    alone = [one for one in found.values() if one.place is None and one.element and one.name.count(".") == 1]
    shorts = {part: "", f"{part}.rate": ".rate", f"{part}.acceleration": ".acceleration"}
    if len(alone) == 1 and full in shorts and part in {joint.name for joint in system.model.joints}:
        full = alone[0].name + shorts[full]  # a joint with a single coordinate
    output = found.get(full) or _beside(system, name, found)
    if output.level > most:
        raise UnknownOutput(
            f"{system.name}: {where} cannot use {name!r}, which depends on {DEPENDS_ON[output.level]}. "
            f"Name an output that depends on {DEPENDS_ON.get(most, 'positions')} at most."
        )
    return output


def _beside(system: System, name: str, found: Mapping[str, Output]) -> Output:
    """A parameter as an output, or the output of a formula."""
    if name in parameters_of(system):
        return Output(name, unit_of_parameter(system.model, name), calls("parameter", name))
    try:
        return _of_formula(system, name)
    except UnknownOutput:
        if OPERATORS.search(name):
            raise
    raise unknown_output(system.name, name, [*found] or [one.name for one in outputs_of(system)])


def components(system: System, name: Any) -> list[str]:
    """The names of the components of a vector, ``pin.force``, ``rod.position``; the name of another output itself."""
    full = _spelt(name).removesuffix(".position") if isinstance(name, str) else ""
    several, found = [f"{full}.{axis}" for axis in "xyz"], _part_of(system, full)[1]
    return several if full not in found and found.keys() >= set(several) else [name]


def _part_of(system: System, full: str) -> tuple[str, dict[str, Output]]:
    """The part that an output is of, with all outputs of it."""
    part = full if ENTRY.fullmatch(full) else part_of(full)
    return part, _of_part(system, part, len(PROVIDERS))


def short(name: str) -> str:
    """Return the name of a body's coordinate as an output: ``slider.x`` for ``slider.r.x``, ``slider.e0``."""
    return name.replace(".r.", ".").replace(".p.", ".")


def _spelt(name: str) -> str:
    """A name in its one spelling: ``slider.x`` for ``slider.r.x``, and ``tool(0.1, 0, 0).x`` whatever the spaces."""
    name = short(name)
    if name.startswith("relative[") and "]" in name:
        names, _, rest = name.removeprefix("relative[").partition("]")
        return f"relative[{', '.join(_spelt(one.strip()) for one in NAME.findall(names))}]{rest}"
    if entry := ENTRY.fullmatch(name):
        return f"{entry['word']}[{', '.join(_spelt(one.strip()) for one in NAME.findall(entry['names']))}]"
    point = POINT.fullmatch(name)
    if point is None:
        return name
    with suppress(ValueError):
        numbers = (repr(float(number)).removesuffix(".0") for number in point["place"].split(","))
        return f"{point['body']}({', '.join(numbers)}){point['rest']}"
    return name


def unknown_output(owner: str, name: str, known: Iterable[str]) -> UnknownOutput:
    """The error for a name that is not there, with names of the nearest part."""
    names, part = list(known), name.split(".")[0]
    parts = {one.split(".")[0] for one in names}
    if part not in parts and re.fullmatch("(mode|pole)0+", part):
        remedy = f"{part[:4].capitalize()}s are numbered from 1: {part[:4]}1{name[len(part) :]}."
        return UnknownOutput(f"{owner} has no output {name!r}. {remedy}")
    if name in parts:
        own = [one for one in names if one.startswith(f"{name}.")]
        scalars = [one for one in own if one.count(".") == 1 or one[-2:] not in (".x", ".y", ".z")]
        return UnknownOutput(f"{owner} has no output {name!r}. {suggest('', scalars or own)}")
    near = [part] if part in parts else get_close_matches(part, parts, n=1)
    nearest = [one for one in names if one.split(".")[0] in near]
    return UnknownOutput(f"{owner} has no output {name!r}. {suggest(name, nearest or names)}")
