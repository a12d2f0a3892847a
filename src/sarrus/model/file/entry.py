"""The base of every mapping in a model file: no key but the declared ones, misspelt ones named."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, model_validator
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
                    raise invalid(f"has no key {quote(key)}; {suggest(key, known)}{cls.instead}", key)
        return data


def invalid(message: str, key: str = "", kind: Literal["invalid", "echo"] = "invalid") -> PydanticCustomError:
    """Return an error that pydantic collects, with its message and the key it is about."""
    return PydanticCustomError(kind, "{message}", {"message": message, "key": key})
