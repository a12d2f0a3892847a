"""Outputs of joints and drivers: ``pin.angle``, ``pin.angle.rate``, ``pin.force.x``, ``motor.power``."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product

from ..model.expansion.blueprint import Placement, blueprint
from ..model.geometry.points import AXES
from ..system import System
from ..system.structure.population import firsts
from .output import Level, Output, among, calls, provides
from .recording import members_of


@provides
def coordinates(system: System, part: str | None) -> Iterator[Output]:
    """Angles and displacements of joints, and their rates."""
    every = system.joint_coordinates
    for name, angle in zip(every.names, every.angles, strict=True):
        if part in (None, name.partition(".")[0]):
            unit = "rad" if angle else "m"
            yield Output(name, unit, calls("joint", name), element=_placed(name))
            yield Output(f"{name}.rate", f"{unit}/s", calls("joint", name, rate=True), Level.VELOCITY)
            second = calls("joint_acceleration", name)
            yield Output(f"{name}.acceleration", f"{unit}/s²", second, Level.ACCELERATION)


@provides
def reactions(system: System, part: str | None) -> Iterator[Output]:
    """Forces, torques and multipliers of joints and drivers."""
    for joint in among(system.rows, part):
        numbers = [str(n + 1) for n in range(len(system.rows[joint]))]
        for n, number in enumerate(numbers):
            yield Output(
                f"{joint}.multiplier.{number}", "", calls("multiplier", joint, at=n), Level.ACCELERATION
            )
        for (word, unit), side, axes in product(
            (("force", "N"), ("torque", "N m")), ("", "_i"), ("", "_body")
        ):
            for n, axis in enumerate(AXES):
                record = calls(word, joint, side, bool(axes), at=n)
                yield Output(f"{joint}.{word}{side}{axes}.{axis}", unit, record, Level.ACCELERATION)
        for body, (word, unit) in product(_bodies(system, joint), (("force_on", "N"), ("torque_on", "N m"))):
            for n, axis in enumerate(AXES):
                record = calls(word, joint, body, at=n)
                yield Output(f"{joint}.{word}.{body}.{axis}", unit, record, Level.ACCELERATION)


def _bodies(system: System, coupling: str) -> list[str]:
    """The bodies that a coupling acts on; none of other parts, which act on two."""
    if not system.marker(coupling).coupled:
        return []
    parts = [(p, k) for p in system.populations if p.kind.rows for k in members_of(p, coupling)]
    found = {system.layout.owner_of[first] for p, k in parts for first in firsts(p, k) if first >= 0}
    return [system.bodies[n] for n in sorted(found) if n < len(system.bodies)]


def _placed(name: str) -> Callable[[System], Placement]:
    def element(system: System) -> Placement:
        return next(one for one in blueprint(system.model).coordinates if f"{one.owner}.{one.label}" == name)

    return element
