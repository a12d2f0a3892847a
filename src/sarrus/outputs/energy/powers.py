"""Supplied and dissipated powers of parts and their integrals: ``motor.power``, ``damper.dissipated_energy``."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

from ...elements import Force
from ...system import System
from ..output import Level, Output, among, calls, provides

WORDS = ("supplied", "dissipated")


def drivers_of(system: System) -> list[str]:
    """Drivers, and joints whose equations contain the time."""
    timed = (owner for p in system.populations if p.kind.rows and p.kind.timed for owner in p.owners if owner)
    return [*dict.fromkeys([*(one.name for one in system.model.drivers), *timed])]


def forces_of(system: System) -> list[str]:
    """Parts with force elements, without the weights of bodies."""
    working = (p for p in system.populations if issubclass(p.kind, Force) and "power" in p.kind.outputs)
    owners = (owner for p in working for owner in p.owners)
    return [owner for owner in dict.fromkeys(owners) if owner not in system.bodies]


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
