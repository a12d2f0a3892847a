"""Texts with units and formulas in every field of every kind of part, in the place of numbers and laws."""

from collections.abc import Iterator
from dataclasses import fields, replace
from numbers import Real
from typing import Any

import numpy as np
import pytest
from tests.outputs.every_kind import system

import sarrus as sr
from sarrus.model.measure import In, measures_of
from sarrus.model.quantity import is_list


def places(part: Any) -> Iterator[tuple[str, In]]:
    """The fields of a part with a quantity, whose value is a number, or a list of numbers."""
    for field in fields(part):
        measure, value = measures_of(part).get(field.name), getattr(part, field.name)
        numbers = list(value) if is_list(value) else [value]
        plain = all(isinstance(one, Real) and not isinstance(one, bool) for one in numbers)
        if measure and measure.unit and plain and numbers:
            yield field.name, measure


def text_of(value: Any, unit: str) -> Any:
    """The same value as a text with its unit."""
    if is_list(value):
        return [text_of(one, unit) for one in value]
    above, *below = unit.split("/")
    plain = "/".join([above, *" ".join(below).split()])  # m/s^2/K
    return f"{float(value)!r}" if unit == "1" else f"{float(value)!r} {plain}"


def changed(part: Any, **texts: str) -> Any:
    """The part with texts in some fields, by their units."""
    return replace(part, **{name: text_of(getattr(part, name), unit) for name, unit in texts.items()})


def test_texts_in_all_fields_are_their_numbers() -> None:
    model = system().model
    parts = {
        section: [changed(part, **{name: one.unit for name, one in places(part)}) for part in own]
        for section, own in model.sections().items()
    }
    assert sum(len([*places(part)]) for own in model.sections().values() for part in own) > 400
    again = sr.System(replace(model, **parts))
    assert again.parameter_names == system().parameter_names
    assert np.allclose(again.b, system().b, rtol=1e-15, atol=0)


def every_field() -> dict[str, tuple[str, Any, str, In]]:
    """One part for each field of each kind."""
    sections = system().model.sections().items()
    parts = [(section, part) for section, own in sections for part in own]
    return {
        f"{type(part).__name__}.{name}": (section, part, name, measure)
        for section, part in parts
        for name, measure in places(part)
    }


def system_with(model: sr.Model, section: str, part: Any, **texts: str) -> sr.System:
    wrong = changed(part, **texts)
    parts = [wrong if one is part else one for one in model.sections()[section]]
    return sr.System(replace(model, **{section: parts}))


def test_texts_in_other_units_are_refused_by_name() -> None:
    model = system().model
    for label, (section, part, name, measure) in every_field().items():
        with pytest.raises(sr.ModelError, match=rf'"{part.name}": {name} (must be|expects)'):
            raise AssertionError(
                label, system_with(model, section, part, **{name: "kg" if measure.unit != "kg" else "m"})
            )


def test_what_is_no_number_is_refused() -> None:
    for text, message in (("a*2", 'unknown name "a"'), ("2 m", "must be in kg"), ("1 2", "out of place")):
        with pytest.raises(sr.ModelError, match=f'body "b": mass .*{message}'):
            sr.System(sr.Model("m", [sr.Body("b", mass=text, inertia=(1, 1, 1))]))
    inside = sr.Body("b", 1, ("2 kg m^2", 1, 1), orientation=sr.AxisAngle(("0", 0, 1), "30 deg"))
    (body,) = sr.Model("m", [inside]).bodies
    assert body.inertia == (2.0, 1, 1)
    assert body.orientation.angle == pytest.approx(np.pi / 6)
    point = (
        sr.Model("m", [inside], forces=[sr.PointForce("f", inside.point("20 mm", 0, 0), (1, 0, 0))])
        .forces[0]
        .point
    )
    assert point.coordinates == (0.02, 0, 0)
