"""Outputs of the whole system: time, energies, inputs and first-order states, ``u``, ``motor.current``."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

from ..model.states.input import InputLaw
from ..system import System
from .energy import WORDS, drivers_of, forces_of
from .output import Level, Output, among, calls, provides


@provides
def totals(system: System, part: str | None) -> Iterator[Output]:
    """``t``, ``energy.kinetic``, ``energy.potential``, their sum ``energy.total``, and ``energy.elastic``."""
    if part in (None, "t"):
        yield Output("t", "s", lambda o: o.t)
    if part in (None, "energy"):
        yield Output("energy.kinetic", "J", calls("kinetic_energy"), Level.VELOCITY)
        yield Output("energy.potential", "J", calls("potential_energy"))
        yield Output("energy.elastic", "J", calls("elastic_energy"), Level.VELOCITY)
        yield Output("energy.total", "J", lambda o: o.kinetic_energy() + o.potential_energy(), Level.VELOCITY)


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


@provides
def amplitudes(system: System, part: str | None) -> Iterator[Output]:
    """Coordinates that parts add to those of bodies, and their rates: ``modes.w1``, ``modes.w1.rate``."""
    layout = system.layout
    for block in layout.moving.blocks[len(layout.bodies.blocks) :]:
        unit, is_asked = "m" if block.kind.is_length else "1", part in (None, block.owner.partition(".")[0])
        for n, word in enumerate(block.kind.parts if is_asked else ()):
            name, place = f"{block.owner}.{word}", block.start + n
            yield Output(name, unit, calls("input", "q", place), place=place)
            yield Output(f"{name}.rate", f"{unit}/s", calls("input", "v", place), Level.VELOCITY)


@provides
def states(system: System, part: str | None) -> Iterator[Output]:
    """The states of a part: of a `StateVariable` its own name, of others ``motor.current``."""
    for kind, level, found in (
        ("v", Level.VELOCITY, system.states),
        ("q", Level.POSITION, system.followed_states),
    ):
        for name, (place, unit, _) in found.items():
            if part in (None, name.partition(".")[0]):
                yield Output(name, unit, calls("input", kind, place), level)


@provides
def of_drivers(system: System, part: str | None) -> Iterator[Output]:
    """Powers of drivers, and the energy that they supplied."""
    for driver in among(drivers_of(system), part):
        record = calls("driving_power", driver)
        yield Output(f"{driver}.power", "W", record, Level.ACCELERATION)
        yield Output(f"{driver}.supplied_power", "W", record, Level.ACCELERATION)
        yield since_start(f"{driver}.supplied_energy", f"{driver}.supplied_power")


@provides
def of_forces(system: System, part: str | None) -> Iterator[Output]:
    """The energy that forces supplied and dissipated."""
    for force in among(forces_of(system), part):
        for word in WORDS:
            yield since_start(f"{force}.{word}_energy", f"{force}.{word}_power")


@provides
def of_all(system: System, part: str | None) -> Iterator[Output]:
    """Powers and energies of all parts: ``energy.supplied`` and ``energy.dissipated``."""
    if part in (None, "energy"):
        for word in WORDS:
            yield Output(f"energy.{word}_power", "W", partial(_total, system, word), Level.ACCELERATION)
            yield since_start(f"energy.{word}", f"energy.{word}_power")


def since_start(name: str, rate: str) -> Output:
    """The integral of a power since the start of a run."""
    return Output(name, "J", calls("accumulated", rate), Level.HISTORY, rate=rate)


def _total(system: System, word: str, o: Any) -> Any:
    parts = [*forces_of(system), *(drivers_of(system) if word == "supplied" else ())]
    return sum((o(f"{part}.{word}_power") for part in parts), o.constant(0.0))
