"""Sampled controllers in Python: functions that set inputs at equal intervals, with a zero-order hold."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ....model import SarrusError
from ....model.arithmetic import Numeric
from ....model.checks.arguments import Number
from ....model.quantity import is_list
from ....model.tape import Tracer, value_of
from ..stepping.stepper import RunFailure
from .readings import Readings


@dataclass(frozen=True, eq=False)
class Controller:
    """A sampled controller of a simulation.

    Parameters
    ----------
    function
        f(t, o) at every sample, which returns the values of inputs by name, ``{"u": 2.0}``, always of the same ones.
        They are held until the next sample. ``o["pin.angle"]`` is an output of positions, velocities, states and
        inputs.
    period
        Time between samples [s]; the first is at the start.
    name
        For messages; by default the function's name.
    memory
        Numbers by name that the function remembers from sample to sample, with their values before the first one, such
        as ``{"integral": 0.0}``: ``o["integral"]`` is what it returned last, and it returns the new value with the
        inputs. Derivatives need it in the place of a memory of the function's own.
    """

    function: Callable[[float, Readings], Mapping[str, Numeric]]
    period: float
    name: str = ""
    memory: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise TypeError(
                "a controller needs a function f(t, o). Give one that returns values of inputs by name."
            )
        Number(positive=True)("period", self.period)
        if not isinstance(self.memory, Mapping):
            raise TypeError(f"memory must be a mapping, got {self.memory!r:.60}. Pass {{'integral': 0.0}}.")
        for name, value in self.memory.items():
            Number()(f"memory {name}", value)

    @property
    def title(self) -> str:
        """The name, or that of the function."""
        return self.name or getattr(self.function, "__name__", "controller")

    def values(self, t: float, readings: Readings) -> dict[str, Any]:
        """The values of its inputs and of its memory at a sample, plain numbers or recorded ones.

        Raises
        ------
        RunFailure
            If one is not finite.
        SarrusError
            If it returns something else than values by name, or not those of its memory.
        """
        found: Any = self.function(t, readings)
        if not isinstance(found, Mapping):
            message = f"controller {self.title}: it returned {found!r:.60}, no values by name"
            raise SarrusError(f"{message}. Return a mapping, such as {{'u': 2.0}}.")
        for name in self.memory:
            if name not in found:
                message = f"controller {self.title}: it returned no value of {name}, which it remembers"
                raise SarrusError(f"{message}. Return it with the inputs.")
        for name, value in found.items():
            plain = np.asarray(value_of(value))
            if plain.dtype.kind not in "biuf" or (plain.ndim and not isinstance(value, Tracer)):
                message = f"controller {self.title}: it returned {value!r:.60} for {name}"
                raise SarrusError(f"{message}. Return one number for each name.")
            if not np.all(np.isfinite(plain)):
                message = f"controller {self.title}: it returned {value} for {name} at t = {t:.6g} s"
                raise RunFailure("controller", f"{message}. Return a finite number.")
        return dict(found)


def controllers_of(given: Any) -> list[Controller]:
    """Return a controller, several or None as a list.

    Raises
    ------
    TypeError
        If there is something else.
    """
    if given is None:
        return []
    found: list[Any] = [given] if isinstance(given, Controller) else [*given] if is_list(given) else [None]
    if not all(isinstance(one, Controller) for one in found):
        raise TypeError(
            "controllers must be a sarrus.Controller, or a list of them. Pass sr.Controller(f, period=0.01)."
        )
    return found
