"""The base of every mapping in a model file, and the types that are made for it at run time."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from functools import reduce
from types import GenericAlias
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Discriminator, Tag, model_validator
from pydantic_core import PydanticCustomError

from ..show import quote, suggest


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
