"""Positions at which the inputs of a mechanism lose control of it, as curves."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from ..algebra import Array


@dataclass(frozen=True)
class SingularCurve:
    """A curve of positions at which the mechanism can move while its inputs stand still.

    Attributes
    ----------
    u : (k, 2) outputs along it; `line` (m, 2) the same more densely
    v : (k, inputs) values of the inputs
    q : (k, nq) positions
    closed : whether it comes back to its start
    """

    u: Array = field(repr=False)
    line: Array = field(repr=False)
    v: Array = field(repr=False)
    q: Array = field(repr=False)
    closed: bool


@dataclass(frozen=True)
class InputSingularities:
    """All such curves that were found.

    Attributes
    ----------
    name : of the system
    outputs, inputs : names of the functions
    """

    name: str
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    curves: tuple[SingularCurve, ...] = field(repr=False)
    status: Literal["mapped", "incomplete"]
    message: str

    @property
    def success(self) -> bool:
        """Whether nothing was lost."""
        return self.status == "mapped"

    def plot(self, ax: Any = None) -> Any:
        """Draw the curves in the plane of the outputs; see `sarrus.views.plot_input_singularities`."""
        from importlib import import_module

        return import_module("sarrus.views").plot_input_singularities(self, ax)
