"""What is replaced in a model when it is created: texts by numbers, moving points of the ground by driven bodies."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any

from ..checks.findings import Findings
from ..errors import ModelError
from ..text_numbers import numbers_of, with_numbers_of_texts
from .moving_points import Carriers
from .named_parameters import refuse_two_values, with_named_parameters

SECTIONS = ("bodies", "joints", "drivers", "forces")
GRAVITY = ("gravity", "m/s^2")


def prepare(model: Any) -> None:
    """Replace parts of a model that is being created; what is wrong stays, see `refuse_unprepared`."""
    given = {section: getattr(model, section) for section in SECTIONS}
    if not all(isinstance(parts, list | tuple) for parts in given.values()):
        return
    with suppress(ModelError):
        object.__setattr__(model, GRAVITY[0], numbers_of(model.gravity, GRAVITY[1], GRAVITY[0]))
    carriers, replaced = _replacing(model)
    found: dict[str, list[Any]] = {section: [] for section in SECTIONS}
    for section, parts in given.items():
        for part in parts:
            found[section].append(part)
            with suppress(ModelError):
                found[section][-1] = replaced(section, part)
    for number, section in enumerate(("bodies", "joints", "drivers")):
        found[section] += [one[number] for one in carriers.found.values()]
    if carriers.constants:
        values = model.formulas.values()
        own = {place: tree.renamed(values) for place, tree in carriers.constants.items()}
        formulas = replace(model.formulas, expressions={**model.formulas.expressions, **own})
        object.__setattr__(model, "formulas", formulas)
    if (formulas := with_named_parameters(model.formulas, found, model.gravity)) is not model.formulas:
        object.__setattr__(model, "formulas", formulas)
    for section, parts in found.items():
        before = given[section]
        if len(parts) != len(before) or any(a is not b for a, b in zip(parts, before, strict=True)):
            object.__setattr__(model, section, tuple(parts))


def refuse_unprepared(model: Any, findings: Findings) -> None:
    """Keep an error for every text that is no number, or in another unit, and every point that cannot move."""
    _, replaced = _replacing(model)
    with findings.about():
        numbers_of(model.gravity, GRAVITY[1], GRAVITY[0])
        refuse_two_values(model)
    for section in SECTIONS:
        for part in getattr(model, section):
            with findings.about(section, part.name):
                replaced(section, part)


def _replacing(model: Any) -> tuple[Carriers, Callable[[str, Any], Any]]:
    """The carriers of a model, and a function that replaces a part."""
    every = [part for section in SECTIONS for part in getattr(model, section)]
    carriers = Carriers(frozenset(str(getattr(part, "name", "")) for part in every))
    return carriers, lambda section, part: with_numbers_of_texts(carriers.replaced(part))
