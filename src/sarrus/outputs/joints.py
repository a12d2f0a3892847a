"""Outputs of joints and drivers: ``pin.angle``, ``pin.angle.rate``, ``pin.force.x``, ``pin.multiplier.1``."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

from ..model import Placed, blueprint
from ..system import System
from .bodies import AXES
from .output import Level, Output, among, provides


@provides
def coordinates(system: System, part: str | None) -> Iterator[Output]:
    """Angles and displacements of joints, and their rates."""
    every = system.joint_coordinates
    for name, angle in zip(every.names, every.angles, strict=True):
        if part in (None, name.partition(".")[0]):
            unit = "rad" if angle else "m"
            yield Output(name, unit, partial(_coordinate, name), element=partial(_placed, name))
            yield Output(f"{name}.rate", f"{unit}/s", partial(_coordinate, name, rate=True), Level.VELOCITY)


@provides
def reactions(system: System, part: str | None) -> Iterator[Output]:
    """Forces, torques and multipliers of joints and drivers."""
    for joint in among(system.rows, part):
        for word, unit in (("force", "N"), ("torque", "N m")):
            for n, axis in enumerate(AXES):
                record = partial(_reaction, word, joint, n)
                yield Output(f"{joint}.{word}.{axis}", unit, record, Level.ACCELERATION)
        for n in range(len(system.rows[joint])):
            record = partial(_reaction, "multiplier", joint, n)
            yield Output(f"{joint}.multiplier.{n + 1}", "", record, Level.ACCELERATION)


def _coordinate(name: str, o: Any, rate: bool = False) -> Any:
    return o.joint(name, rate=rate)


def _reaction(word: str, joint: str, n: int, o: Any) -> Any:
    return getattr(o, word)(joint)[n]


def _placed(name: str, system: System) -> Placed:
    return next(one for one in blueprint(system.model).coordinates if f"{one.owner}.{one.label}" == name)
