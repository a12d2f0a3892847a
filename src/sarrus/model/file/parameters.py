"""The parameters of a model file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import AfterValidator

from ..expression.functions import CONSTANTS
from ..names import matches
from ..show import quote
from .entry import invalid
from .form import mapping_of, marked, one_of
from .stated import number_in

WORD = r"[^\W\d]\w*"
TAKEN = (*CONSTANTS, "t")


def _check_names(given: dict[str, Any]) -> dict[str, Any]:
    for name in given:
        if not matches(WORD, name):
            message = (
                f"has the name {quote(name)}, which must be letters, digits and _, starting with a letter"
            )
            raise invalid(f"{message}; rename it", name)
        if name in TAKEN:
            raise invalid(f"has the name {quote(name)}, which has a meaning of its own; rename it", name)
    return given


def _form(value: Any) -> str:
    return "group" if isinstance(value, Mapping) else "number"


Names = AfterValidator(_check_names)
Group: Any = marked(mapping_of(number_in("")), Names)
Parameters: Any = marked(mapping_of(one_of(_form, number=number_in(""), group=Group)), Names)
