"""The mapping that describes one body, joint or force, derived from its dataclass.

``body_i, body_j`` become ``bodies: [i, j]``, likewise points and frames; every other field keeps its
name. So a new joint or force needs no line here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import MISSING, Field, fields
from functools import cache
from typing import Annotated, Any, Literal, NamedTuple, get_type_hints

import pydantic
from pydantic import create_model

from ..checks.findings import Path
from ..errors import ModelError, restated
from ..expression import Expression
from ..expression.formula_value import FormulaValue
from ..registry import kind_name
from ..show import quote
from .fields import Solids, form_of
from .stated import Entry, invalid

PLURAL = {"body": "bodies", "point": "points", "frame": "frames", "joint": "joints"}


class Slot(NamedTuple):
    """One key of the mapping, the dataclass fields that it fills, and their default."""

    key: str
    fields: tuple[str, ...]
    form: object
    default: object
    hint: object

    @property
    def attribute(self) -> str:
        """Its name in the pydantic model, whose own attributes it does not hide."""
        return f"{self.key}_" if hasattr(Entry, self.key) else self.key

    def definition(self) -> tuple[Any, Any]:
        """Return type and default as pydantic takes them; a key that is left out may not be empty."""
        options: dict[str, Any] = {} if self.default is MISSING else {"default": self.default}
        if self.default is None:
            options = {"default_factory": lambda: None}
        if self.attribute != self.key:
            options["alias"] = self.key
        return self.form, pydantic.Field(**options)


@cache
def slots(kind: type) -> list[Slot]:
    """Return the keys that describe an object of ``kind``, without its name."""
    hints = get_type_hints(kind, include_extras=True)
    names = {field.name for field in fields(kind)}
    collected: dict[str, Slot] = {}
    for field in fields(kind):
        if field.name != "name":
            slot = _slot(field, hints[field.name], names)
            before = collected.get(slot.key)
            collected[slot.key] = _paired(before, slot) if before else slot
    return list(collected.values())


def entry_model(kind: type, *, tagged: bool) -> type[Entry]:
    """Return the pydantic model of the mapping, with the key ``type`` if it is ``tagged``."""
    definitions: dict[str, Any] = {"type": (Literal[kind_name(kind)], ...)} if tagged else {}
    definitions |= {slot.attribute: slot.definition() for slot in slots(kind)}
    doc = (kind.__doc__ or "").strip().partition("\n")[0]
    model: type[Entry] = create_model(kind.__name__, __base__=Entry, __doc__=doc, **definitions)
    return model


@cache
def tagged_model(kind: type) -> type[Entry]:
    """Return the pydantic model of a joint, driver or force; or one that refuses it if files cannot.

    So a user's class that only Python can build does not disturb files in which its type does not appear.
    """
    reason, model = _described(kind)
    return _refusing(kind, reason) if model is None else model


def refuse_undescribable(kind: type) -> None:
    """Raise a ModelError for a class of joints, drivers or forces that only Python can build."""
    if reason := _described(kind)[0]:
        raise ModelError(reason)


@cache
def _described(kind: type) -> tuple[str, type[Entry] | None]:
    """Return the pydantic model of a joint, driver or force, or the reason why there is none."""
    try:
        if "__init__" in vars(kind) and "__dataclass_fields__" not in vars(kind):
            raise TypeError("it has an __init__ of its own instead of the fields of a dataclass")
        return "", entry_model(kind, tagged=True)
    except (TypeError, NameError, AttributeError, pydantic.PydanticUserError) as error:
        reason = str(error).partition("\n")[0].rstrip(".")
        name = quote(kind_name(kind))
        return f"has the type {name}, which model files cannot describe: {reason}. Build it in Python.", None


def _refusing(kind: type, reason: str) -> type[Entry]:
    name = kind_name(kind)

    def refuse(data: Any) -> Any:
        raise invalid(reason)

    validators: dict[str, Any] = {"refuse": pydantic.model_validator(mode="before")(refuse)}
    definition: Any = Literal[name], pydantic.Field(json_schema_extra={"not": {}})
    model: type[Entry] = create_model(
        kind.__name__, __base__=Entry, __validators__=validators, type=definition
    )
    return model


def build(kind: type, name: str, entry: Entry, solids: Solids) -> Any:
    """Return the object of ``kind`` that a mapping describes."""
    arguments: dict[str, Any] = {"name": name}
    for slot in slots(kind):
        value = getattr(entry, slot.attribute)
        if value is not None:
            values = value if len(slot.fields) == 2 else [value]
            arguments |= {f: _built(v, f, solids) for f, v in zip(slot.fields, values, strict=True)}
    return kind(**arguments)


def _slot(field: Field[Any], hint: Any, names: set[str]) -> Slot:
    stem = field.name.rpartition("_")[0]
    pair = {f"{stem}_i", f"{stem}_j"}
    key = PLURAL[stem] if stem in PLURAL and field.name in pair <= names else field.name
    default = field.default if field.default_factory is MISSING else None
    return Slot(key, (field.name,), form_of(hint, field.name), default, hint)


def _paired(i: Slot, j: Slot) -> Slot:
    pair = Annotated[list[j.form], pydantic.Field(min_length=2, max_length=2)]  # type: ignore[name-defined]
    return Slot(j.key, i.fields + j.fields, pair, j.default, j.hint)


def _built(value: Any, field: str, solids: Solids) -> Any:
    if isinstance(value, list):
        return [_built(entry, field, solids) for entry in value]
    if not hasattr(value, "build"):
        return value
    with restated(field=field):
        return value.build(solids)


def formulas(entry: Any, path: Path = ()) -> Iterator[tuple[Path, Expression]]:
    """Yield path and formula of every number that a formula gave."""
    if isinstance(entry, FormulaValue):
        yield path, entry.expression
    for step, value in _entries(entry):
        yield from formulas(value, (*path, step))


def _entries(entry: Any) -> Iterator[tuple[str | int, Any]]:
    if isinstance(entry, Entry):
        for name, field in type(entry).model_fields.items():
            yield field.alias or name, getattr(entry, name)
    elif isinstance(entry, Mapping):
        yield from entry.items()
    elif isinstance(entry, list | tuple):
        yield from enumerate(entry)
