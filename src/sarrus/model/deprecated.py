"""Former public names: deprecated ones are accepted for one release, withdrawn ones name what replaces them."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")
C = TypeVar("C", bound=type)

ATTRIBUTES = {"StudyTable": {"to_pandas": "to_frame"}}  # deprecated, by class
VERIFY = "sr.verify(result, responses, wrt), which repeats the analysis with smaller tolerances"
WITHDRAWN = {
    "sarrus": {"Turn": "sr.Rotation", "Happened": "sr.EventRecord", "Peak": "sr.Maximum"},
    "Gradient": {"relative_errors": VERIFY},
    "Hessian": {"relative_error": VERIFY},
    "ErrorEstimate": {"vibrations": VERIFY},
    "Mobility": {"kept": "independent_rows"},
    "System": {"number_names": "parameter_names"},
    "ModelError": {"sentence": "message"},
}


class _FormerAttribute:
    """An attribute that raises an error."""

    def __init__(self, *name: str) -> None:
        self._name = name

    def __get__(self, instance: object, owner: type) -> _FormerAttribute:
        if instance is None:
            return self
        raise AttributeError(withdrawn(*self._name))


def with_former_names(kind: C) -> C:
    """Decorate a class with the attributes that have deprecated or withdrawn names."""
    for old, new in ATTRIBUTES.get(kind.__name__, {}).items():
        setattr(kind, old, _deprecated_attribute(kind.__name__, old, new))
    for old in WITHDRAWN.get(kind.__name__, {}):
        setattr(kind, old, _FormerAttribute(kind.__name__, old))
    return kind


def withdrawn(kind: str, name: str) -> str:
    """Return the message about a name that was withdrawn, empty for others."""
    new = WITHDRAWN[kind].get(name)
    return f"{kind}.{name} was withdrawn. Use {new}." if new else ""


def deprecated_function(old: str, new: str, function: Callable[P, R]) -> Callable[P, R]:
    """A function under its old name, at whose use the new one is named."""

    @wraps(function)
    def renamed(*args: P.args, **kwargs: P.kwargs) -> R:
        warnings.warn(f"{old} is deprecated. Use {new}.", DeprecationWarning, stacklevel=2)
        return function(*args, **kwargs)

    renamed.__name__ = renamed.__qualname__ = old
    return renamed


def _deprecated_attribute(kind: str, old: str, new: str) -> property:
    def get(self: Any) -> Any:
        warnings.warn(f"{kind}.{old} is deprecated. Use {new}.", DeprecationWarning, stacklevel=2)
        return getattr(self, new)

    return property(get, doc=f"The deprecated name of `{new}`.")
