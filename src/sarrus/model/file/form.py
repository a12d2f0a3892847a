"""Types that are made at run time, for pydantic."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from functools import reduce
from types import GenericAlias
from typing import Annotated, Any

from pydantic import Discriminator, Tag


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
