"""Numbers in a model file: plain, with a unit, or as a formula; and lists of such numbers."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from contextlib import suppress
from functools import cache, partial, reduce
from types import GenericAlias
from typing import Annotated, Any, ClassVar, Literal, TypeAlias

from pydantic import (
    AfterValidator,
    AllowInfNan,
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    InstanceOf,
    Strict,
    Tag,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WithJsonSchema,
    WrapValidator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from ..errors import ModelError
from ..expression import Expression
from ..expression import Number as Constant
from ..expression.formula_value import FormulaValue
from ..laws.curve import Formula, Tree
from ..laws.text_units import variable_of
from ..show import quote, suggest
from .numbers import Echo, Numbers
from .text.document import NUMBER


class Entry(BaseModel):
    """A mapping with fixed keys."""

    model_config = ConfigDict(extra="forbid")
    instead: ClassVar[str] = ""  # what may stand in place of the mapping, for the message about a wrong key

    @model_validator(mode="before")
    @classmethod
    def _refuse_unknown(cls, data: Any) -> Any:
        if isinstance(data, dict):
            known = [field.alias or name for name, field in cls.model_fields.items()]
            for key in data:
                if key not in known:
                    raise invalid(f"has no key {quote(key)}. {suggest(key, known)}{cls.instead}", key)
        return data


def invalid(message: str, key: str = "", kind: Literal["invalid", "echo"] = "invalid") -> PydanticCustomError:
    """Return an error that pydantic collects, with its message and the key it is about."""
    return PydanticCustomError(kind, "{message}", {"message": message, "key": key})


def marked(base: Any, *marks: Any) -> Any:
    """Return ``Annotated[base, *marks]``."""
    return operator.getitem(Annotated, (base, *marks))


def list_of(item: Any) -> Any:
    """Return ``list[item]``."""
    return GenericAlias(list, (item,))


def mapping_of(item: Any) -> Any:
    """Return ``Mapping[str, item]``."""
    return operator.getitem(Mapping, (str, item))  # type: ignore[call-overload]


def one_of(choose: Any, **forms: Any) -> Any:
    """Return a union of forms, of which ``choose`` names the right one.

    Pydantic gives the names in parentheses at the place of an error: no key looks like that, see
    validation_messages.py.
    """
    tagged = [marked(form, Tag(f"({name})")) for name, form in forms.items()]
    return marked(reduce(operator.or_, tagged), Discriminator(lambda value: f"({choose(value)})"))


Handler: TypeAlias = ValidatorFunctionWrapHandler


@cache
def number_in(unit: str) -> Any:
    """Return the form of one number in an SI unit; with ``""`` for any unit."""
    schema = {"type": ["number", "string"], **_described(unit)}
    wrap = WrapValidator(partial(_number, unit))
    return marked(float, Strict(), AllowInfNan(False), wrap, WithJsonSchema(schema))


@cache
def list_in(unit: str, count: int, named: bool = False) -> Any:
    """Return the form of a list of numbers in an SI unit; ``named`` if a point's name may stand for it."""
    numbers = marked(list_of(number_in(unit)), Field(min_length=count, max_length=count))
    return _or_name(numbers, _described(unit), count) if named else numbers


@cache
def direction() -> Any:
    """Return the form of a direction: three plain numbers or lengths, or the names of two points."""
    component = marked(number_in("1"), WrapValidator(_component))
    numbers = marked(list_of(component), Field(min_length=3, max_length=3))
    vector = {"type": "array", "items": {"type": ["number", "string"]}, "minItems": 3, "maxItems": 3}
    points = {"type": "array", "items": {"type": "string", "description": "The name of a point."}}
    schema = {"anyOf": [vector, {**points, "minItems": 2, "maxItems": 2}]}
    return marked(numbers, WrapValidator(_direction), WithJsonSchema(schema))


@cache
def place_in(unit: str, named: bool = False) -> Any:
    """Return the form of three coordinates, which may be formulas in t: those of a point that moves."""
    place = marked(list_of(law_in(unit, "s")), Field(min_length=3, max_length=3), AfterValidator(_moving))
    return _or_name(place, _described_law(unit, "t"), 3) if named else place


@cache
def function_in(unit: str, over: str) -> Any:
    """Return the form of a function of t, such as ``10 N * sin(2*pi*t)``."""
    schema = {
        "type": ["number", "string"],
        "description": f"[{unit}], a formula in {variable_of(over)} [{over}]",
    }
    wrap = WrapValidator(partial(_function, unit, over))
    return marked(InstanceOf[Expression], wrap, WithJsonSchema(schema))


class Law(Tree):
    """A formula in a place that may also hold a table: a number if it is constant, else a function."""

    def build(self, solids: Any) -> Formula:
        return Formula(Tree(self.tree, self.variable))


@cache
def law_in(unit: str, over: str, outputs: bool = False, states: bool = False) -> Any:
    """Return the form of a number, or of a formula in t, x, states or outputs, in the place of a curve."""
    of = "outputs and t" if outputs else "states and t" if states else variable_of(over)
    schema = {"type": ["number", "string"], **_described_law(unit, of)}
    wrap = WrapValidator(partial(_law, unit, over, outputs, states))
    return marked(number_in(unit), wrap, WithJsonSchema(schema))


def _law(
    unit: str, over: str, outputs: bool, states: bool, value: Any, handler: Handler, info: ValidationInfo
) -> Any:
    if not isinstance(value, str) or NUMBER.fullmatch(value):
        return handler(value)
    if outputs and set((tree := _reported(_numbers(info).of_outputs, value)).names()) - {variable_of(over)}:
        return tree
    if states and (found := _reported(_numbers(info).of_states, value, unit)):
        return found
    tree = _reported(_numbers(info).function, value, unit, over)
    return Law(tree, variable_of(over)) if tree.names() else handler(value)


def _number(unit: str, value: Any, handler: Handler, info: ValidationInfo) -> Any:
    if not isinstance(value, str):
        return handler(value)
    return _reported(_numbers(info).number, value, unit)


def _moving(place: list[Any], info: ValidationInfo) -> list[Any]:
    """Return the coordinates; where one is a formula in t, those computed from parameters become formulas in t."""
    if not any(isinstance(one, Law) for one in place):
        return place
    numbers = _numbers(info)
    return [
        Law(numbers.with_values(one.expression), "t") if isinstance(one, FormulaValue) else one
        for one in place
    ]


def point_in(name: str, info: ValidationInfo) -> list[float]:
    """Return the coordinates of a named point. [m]"""
    numbers = _numbers(info)
    return [
        _reported(numbers.number, x, "m") if isinstance(x, str) else x for x in _reported(numbers.point, name)
    ]


def _point(value: Any, handler: Handler, info: ValidationInfo) -> Any:
    return handler(_reported(_numbers(info).point, value) if isinstance(value, str) else value)


def _component(value: Any, handler: Handler, info: ValidationInfo) -> Any:
    """A component of a direction; one that is no plain number may be a length."""
    with suppress(ModelError):
        return _numbers(info).number(value, "m") if isinstance(value, str) else handler(value)
    return handler(value)


def _direction(value: Any, handler: Handler, info: ValidationInfo) -> Any:
    if isinstance(value, list) and len(value) == 2 and all(isinstance(one, str) for one in value):
        value = _reported(_numbers(info).axis, *value)
    return handler(value)


def _function(unit: str, over: str, value: Any, handler: Handler, info: ValidationInfo) -> Any:
    if isinstance(value, float):
        return Constant(value)
    if not isinstance(value, str):
        return handler(value)
    return _reported(_numbers(info).function, value, unit, over)


def _numbers(info: ValidationInfo) -> Numbers:
    return info.context if isinstance(info.context, Numbers) else Numbers({})


def _reported(work: Any, *args: Any) -> Any:
    """Do some work, and hand its ModelError to pydantic, which knows where in the file it belongs."""
    try:
        return work(*args)
    except Echo as error:
        raise invalid(error.message, kind="echo") from None
    except ModelError as error:
        raise invalid(error.message) from None


def _described(unit: str) -> dict[str, str]:
    return {"description": f"[{unit}]"} if unit not in ("", "1") else {}


def _described_law(unit: str, of: str) -> dict[str, str]:
    return {"description": f"[{unit}], or a formula in {of}"}


def _or_name(numbers: Any, described: dict[str, str], count: int) -> Any:
    """Return the schema of a list of numbers that accepts the name of a point in its place."""
    item = {"type": ["number", "string"], **described}
    items = {"type": "array", "items": item, "minItems": count, "maxItems": count}
    schema = {"anyOf": [items, {"type": "string", "description": "The name of a point."}]}
    return marked(numbers, WrapValidator(_point), WithJsonSchema(schema))
