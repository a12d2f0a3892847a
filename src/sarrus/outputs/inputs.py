"""Inputs by name: ``u``."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

from ..model.states.input import InputLaw
from ..system import System
from .output import Output, provides


@provides
def inputs(system: System, part: str | None) -> Iterator[Output]:
    """The inputs of a system."""
    for name, one in system.inputs.items():
        if part in (None, name):
            yield Output(name, one.unit, partial(_value, system, name))


def _value(system: System, name: str, o: Any) -> Any:
    """The value of an input over time."""
    found = (
        (p, p.owners.index(name))
        for p in system.populations
        if issubclass(p.kind, InputLaw) and name in p.owners
    )
    return o.scalars(*next(found), "values", 3)[0]
