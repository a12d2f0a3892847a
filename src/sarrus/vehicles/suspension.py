"""The analysis of a suspension on a rig: bump, roll and steer."""

from __future__ import annotations

from collections.abc import Sequence

from ..model import AngleDriver, SarrusError
from ..model.announcement import reports_warnings
from ..model.checks.arguments import CHECKS, in_si
from ..model.quantity import is_list, numbers
from ..model.show import suggest
from ..system import System
from .characteristics import SweepName
from .corner import FORWARD, Corner, PlacedCorner, Side
from .result import Suspension
from .rig import Rig, coordinate, in_design_position
from .wheel import Vehicle


@reports_warnings
def suspension(
    system: System,
    left: Corner | None = None,
    right: Corner | None = None,
    *,
    bump: Sequence[float] | None = (-0.05, 0.05),
    roll: Sequence[float] | None = (-0.03, 0.03),
    steering: str = "",
    steer: Sequence[float] | None = None,
    steps: int = 20,
    fixed: Sequence[str] = (),
    forward: str = "x",
    vehicle: Vehicle | None = None,
    strict: bool = False,
) -> Suspension:
    """Analyse the kinematics of a suspension on a rig: bump, roll and steer.

    Pads move the wheel centres up and down, a driver moves the steering. The rig replaces the drivers and the tyres of
    the model. All positions follow from the constraints, and all slopes from the exact derivatives along the sweep.

    Parameters
    ----------
    system : System, with z upward; the rig starts from its design position
    left, right : the wheels, one or both
    bump : lowest and highest displacement of the wheels, both in parallel [m], or texts such as "30 mm"; None for no
        sweep
    roll : the same for opposite displacements; those of the right wheel
    steering : the joint coordinate that steers: a rack, ``rack``, or a shaft; it is held in bump and roll
    steer : its lowest and highest displacement [m] or [rad] from the design position
    steps : intervals on both sides of the design position
    fixed : bodies that are fixed in their design position, such as the chassis
    forward : direction of travel in global axes: "x", "-x", "y" or "-y"
    vehicle : dimensions of the vehicle
    strict : raise the first warning as a `StrictError`

    Returns
    -------
    Suspension
        With ``success`` false if a sweep ends early: its curves are then shorter, and ``message`` states why.

    Raises
    ------
    SarrusError
        For wheels without a spindle, unknown names, displacements beyond the diameter of a wheel, and parts that the
        rig leaves free to move.
    """
    if forward not in FORWARD:
        known = ", ".join(FORWARD)
        raise SarrusError(f"forward must be one of {known}, got {forward!r}. Choose one of them.")
    system = in_design_position(system)
    wheels: list[tuple[Side, Corner | None]] = [("left", left), ("right", right)]
    corners = {side: PlacedCorner(system, one, side, forward) for side, one in wheels if one is not None}
    if not corners:
        raise SarrusError("suspension: there is no wheel. Give left=sr.Corner(...), right=, or both.")
    CHECKS["variables"]("fixed", fixed)
    if vehicle is not None and not isinstance(vehicle, Vehicle):
        raise SarrusError(f"vehicle must be a vehicle, got {vehicle!r}. Give sr.Vehicle(...).")
    for name in fixed:
        if name not in system.bodies:
            raise SarrusError(f"fixed: the model has no body {name!r}. {suggest(name, [*system.bodies])}")
    if steering:
        coordinate(system, steering)
    elif steer is not None:
        raise SarrusError("steer: no joint steers. Name the rack or the shaft, steering='rack'.")
    rig = Rig(system, corners, steering, tuple(fixed))
    rig.refuse_forces_of_tyres()
    roll = roll if len(corners) > 1 else None
    limits: dict[SweepName, Sequence[float] | None] = {"bump": bump, "roll": roll, "steer": steer}
    diameter = 2 * min(one.corner.radius for one in corners.values())
    units = {"steer": "rad"} if steering and coordinate(system, steering)[0] is AngleDriver else {}
    sweeps = {
        name: rig.sweep(name, _limits(name, one, units.get(name, "m"), diameter), steps)
        for name, one in limits.items()
        if one is not None
    }
    if any(one.kingpin is None for one in (left, right) if one) and rig.has_virtual_kingpins:
        kingpins = rig.virtual_kingpins()
        sweeps |= {"kingpin": kingpins} if kingpins else {}
    if not sweeps:
        raise SarrusError(f"{system.name}: there is no sweep. Give limits of bump, of roll or of steer.")
    stopped = " ".join(one.stopped for one in sweeps.values() if one.stopped)
    message = stopped or "all sweeps reached their ends"
    return Suspension(system.name, rig, vehicle or Vehicle(), sweeps, not stopped, message)


def _limits(name: str, limits: Sequence[float], unit: str, diameter: float) -> tuple[float, float]:
    """The limits of a sweep, which are on both sides of 0, and displacements not larger than a wheel."""
    given = [in_si(name, one, unit) for one in limits] if is_list(limits) else limits
    low, high = numbers(given, 2, name, "Give the lowest and the highest displacement, as in (-0.05, 0.05).")
    if not low <= 0.0 <= high or low == high:
        message = f"the limits must be on both sides of 0, got {low:g} and {high:g}"
        raise SarrusError(f"{name}: {message}. Exchange or change them.")
    if unit == "m" and max(-low, high) > diameter:
        message = f"{max(-low, high):g} m is more than the diameter of a wheel, {diameter:g} m"
        raise SarrusError(f"{name}: {message}. Give displacements in m, as in (-0.05, 0.05).")
    return low, high
