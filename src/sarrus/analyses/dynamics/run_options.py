"""Options of a run besides its method: events and breakpoints, limits, the folder in which it is saved."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, Literal, TypeAlias

import numpy as np

from ...algebra import Array
from ...model import ModelError
from ...model.checks.arguments import CHECKS, TEXTS, Number
from ...model.show import quote, show
from .events.events import Event

Stored: TypeAlias = Literal["samples", "dense", "steps"]
Events: TypeAlias = Event | float | Sequence[Event | float] | Array
Goals: TypeAlias = Mapping[Any, "float | str"]
STORED: tuple[Stored, ...] = ("samples", "dense", "steps")


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Limits of a run, see `simulate`.

    Parameters
    ----------
    time : seconds after which the run ends with the status "time limit"; with `errors`, of all its runs. Outputs
        that are computed when they are first used do not count
    steps : number of steps after which the run ends with the status "too many steps"; by default it ends if
        60,000 steps were so short that five million more would follow
    errors : largest errors of responses, ``{"slider.x": "1 um", sr.Maximum("pin.force.x"): 0.5}``: the run is repeated
        with smaller tolerances or steps until the estimates of `Trajectory.error` are smaller; its steps are stored

    Raises
    ------
    ValueError
        For limits that are not positive.
    """

    time: float | None = None
    steps: int | None = None
    errors: Goals | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", TEXTS["time_limit"]("time", self.time))
        for name, check in (("time", "time_limit"), ("steps", "max_steps")):
            if getattr(self, name) is not None:
                CHECKS[check](name, getattr(self, name))


@dataclass(frozen=True)
class Save:
    """The folder in which a run is saved while it is computed, see `simulate`.

    Parameters
    ----------
    folder : such as "run.sarrus"; new or empty
    overwrite : whether a run that the folder contains is replaced
    """

    folder: str | os.PathLike[str]
    _: KW_ONLY
    overwrite: bool = False

    def __post_init__(self) -> None:
        CHECKS["folder"]("save", self.folder)
        CHECKS["overwrite"]("overwrite", self.overwrite)


def limits_of(given: Any) -> Limits:
    """The limits of an option of `simulate`.

    Raises
    ------
    TypeError
    """
    if given is not None and not isinstance(given, Limits):
        raise TypeError(f"limits must be sr.Limits, got {show(given)}. Pass sr.Limits(time=60.0).")
    return Limits() if given is None else given


def save_of(given: Any) -> Save | None:
    """The folder of an option of `simulate`."""
    return given if given is None or isinstance(given, Save) else Save(given)


def refuse_store(given: Any) -> None:
    """Refuse an option ``store`` that is none.

    Raises
    ------
    ValueError
    """
    if not isinstance(given, str) or given not in STORED:
        raise ValueError(f'store must be "samples", "dense" or "steps", but is {show(given)}. Choose one.')


def listed_events(given: Any) -> list[Event | float]:
    """The events of an option of `simulate`, and the breakpoints among them.

    Raises
    ------
    TypeError
        For anything else.
    ValueError
        For a breakpoint that is not finite.
    ModelError
        If two events have the same name, by which their records and derivatives are known.
    """
    if isinstance(given, np.ndarray):
        given = given.ravel().tolist()
    listed = [*given] if isinstance(given, list | tuple) else [given]
    for one in listed:
        if not isinstance(one, Event | int | float | np.number) or isinstance(one, bool):
            raise TypeError(
                f"events must be a sarrus.Event, a time of a breakpoint in s, or a list of them, got "
                f"{type(one).__name__}. Pass sr.Event(...)."
            )
        if not isinstance(one, Event):
            Number()("a breakpoint among events", one)
    titles = [one.title for one in listed if isinstance(one, Event)]
    if len(set(titles)) < len(titles):
        twice = next(title for title in titles if titles.count(title) > 1)
        raise ModelError(f"events: two are named {quote(twice)}. Give each of them its own name=.")
    return [one if isinstance(one, Event) else float(one) for one in listed]


def events_of(given: Any) -> tuple[list[Event], Array]:
    """The events, and the times of the breakpoints, of an option of `simulate`."""
    listed = listed_events(given)
    times = np.array([one for one in listed if not isinstance(one, Event)], dtype=float)
    return [one for one in listed if isinstance(one, Event)], times
