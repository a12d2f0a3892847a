"""What is replaced in a model when it is created: texts by numbers, moving points of the ground by driven bodies."""

from __future__ import annotations

from dataclasses import replace
from operator import is_
from typing import Any

from ..checks.findings import Findings
from ..text_numbers import numbers_of, with_numbers_of_texts
from .moving_points import Carriers
from .named_parameters import GRAVITY, formulas_in, refuse_two_values, with_named_parameters

SECTIONS = ("bodies", "joints", "drivers", "forces")
PREPARED = "_prepared"  # attribute of a model: what was right when it was created, to be compared by identity


def prepare(model: Any) -> None:
    """Replace parts of a model that is being created; what is wrong stays, see `refuse_unprepared`."""
    if all(isinstance(getattr(model, section), list | tuple) for section in SECTIONS):
        findings = Findings(model.origin)
        for name, value in _prepared(model, findings).items():
            object.__setattr__(model, name, value)
        object.__setattr__(model, PREPARED, () if findings.errors else _checked(model))


def refuse_unprepared(model: Any, findings: Findings) -> None:
    """Keep an error for every text that is no number, or in another unit, and every point that cannot move."""
    if not (before := getattr(model, PREPARED, ())) or not all(map(is_, before, _checked(model))):
        _prepared(model, findings)


def _prepared(model: Any, findings: Findings) -> dict[str, Any]:
    """The sections, gravity and formulas of a prepared model; what is wrong stays, and has an error."""
    gravity, formulas = model.gravity, model.formulas
    with findings.about():
        gravity = numbers_of(gravity, "m/s^2", GRAVITY)
    given = {section: getattr(model, section) for section in SECTIONS}
    carriers = Carriers(
        frozenset(str(getattr(part, "name", "")) for parts in given.values() for part in parts)
    )
    found: dict[str, list[Any]] = {section: [] for section in SECTIONS}
    for section, parts in given.items():
        for part in parts:
            found[section].append(part)
            with findings.about(section, str(getattr(part, "name", ""))):
                found[section][-1] = with_numbers_of_texts(carriers.replaced(part))
    for number, section in enumerate(("bodies", "joints", "drivers")):
        found[section] += [one[number] for one in carriers.found.values()]
    if carriers.constants:
        own = {at: tree.renamed(formulas.values()) for at, tree in carriers.constants.items()}
        formulas = replace(formulas, expressions={**formulas.expressions, **own})
    named = formulas_in(found, gravity)
    formulas = with_named_parameters(formulas, named)
    with findings.about():
        refuse_two_values(formulas, named)
    return {
        **{section: tuple(parts) for section, parts in found.items()},
        GRAVITY: gravity,
        "formulas": formulas,
    }


def _checked(model: Any) -> tuple[Any, ...]:
    """What is prepared in a model: values that nobody changes."""
    return tuple(getattr(model, name) for name in (*SECTIONS, GRAVITY, "formulas"))
