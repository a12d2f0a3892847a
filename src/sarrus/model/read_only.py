"""Arrays of results as views that cannot be written: results are values."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any

import numpy as np

RESULTS = f"{__package__.partition('.')[0]}.results."  # the package of their parts


def read_only(value: Any) -> Any:
    """A new result, or a container of arrays and results, with arrays that cannot be written.

    Of a result itself the arrays are replaced by views, so that what computed them may go on with its own; fields that
    are no part of its value, such as its system and its steps, stay as they are.
    """
    kind: Any = type(value)
    if isinstance(value, np.ndarray):
        return _array(value)
    if isinstance(value, list):
        value[:] = map(read_only, value)
    elif kind is tuple:
        return tuple(map(read_only, value))
    elif hasattr(value, "_make"):
        return value._make(map(read_only, value))
    elif kind is dict:
        return {key: read_only(one) for key, one in value.items()}
    elif names := _fields(kind):
        known = value.__dict__  # also of a frozen one; fields that are computed later are not there yet
        known.update({name: read_only(known[name]) for name in names if name in known})
    return value


@cache
def _fields(kind: Any) -> tuple[str, ...]:
    """The fields of a result that are part of its value; none of other classes."""
    is_result = hasattr(kind, "call") or kind.__module__.startswith(RESULTS)
    return tuple(one.name for one in fields(kind) if one.compare) if is_dataclass(kind) and is_result else ()


def _array(value: Any) -> Any:
    found = value.view() if type(value) is np.ndarray else value  # others have attributes
    found.setflags(write=False)
    return found
