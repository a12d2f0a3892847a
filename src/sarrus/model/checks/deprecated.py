"""Deprecated spellings of public names: accepted for one release, with a DeprecationWarning."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

RENAMED = {"keep_steps": "store_steps"}  # old keyword: new keyword, in every function that has the new one


def warn_deprecated(old: str, new: str, depth: int = 2) -> None:
    """Warn who called the function that calls this one, or who is further up by a depth."""
    warnings.warn(f"{old} is deprecated. Use {new}.", DeprecationWarning, stacklevel=depth + 1)


def accepts_deprecated_keywords(function: Callable[P, R]) -> Callable[P, R]:
    """Decorate an analysis, below `reports_warnings`, that also accepts the old spellings of its keywords."""

    @wraps(function)
    def translating(*args: P.args, **kwargs: P.kwargs) -> R:
        for old in RENAMED.keys() & kwargs.keys():
            new = RENAMED[old]
            if new in kwargs:
                raise TypeError(f"{old} is the old spelling of {new}. Give {new} only.")
            warn_deprecated(old, new, 3)
            kwargs[new] = kwargs.pop(old)
        return function(*args, **kwargs)

    return translating
