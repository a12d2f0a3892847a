"""Arguments of a wrong kind, refused with the right call."""

from __future__ import annotations

from ..model import SarrusError
from ..model.announcement import carry
from ..system import System

OF_POSITIONS_ONLY = ("assemble", "mobility")  # analyses that depend on inputs of drivers alone
STEADY_ONLY = ("modes",)  # analyses that accept constraints on velocities, but no drivers that follow states
OF_STATES = "Simulate, or give the drivers laws over time."
OF_POSITIONS = "these constraints do not restrict positions. Leave the joint out of the model."


def refuse_other_system(
    system: object, analysis: str, *, nonholonomic: str = "", unset: bool = False
) -> None:
    """Refuse what is no system, or has inputs without values; the result of the analysis carries the warnings of one.

    `unset` permits inputs without values. `nonholonomic` is why constraints on velocities are refused, too, and what
    to do.

    Raises
    ------
    TypeError
        With the right call.
    SarrusError
        With the first of the inputs without a value, of drivers that follow states, or of the joints that roll.
    """
    if isinstance(system, System):
        if (nonholonomic or analysis in STEADY_ONLY) and system.followed_states:
            raise SarrusError(
                f"{system.name}: {analysis} is not possible with drivers that follow states. {OF_STATES}"
            )
        if nonholonomic and system.m_holonomic < system.m:
            joint = next(name for name, rows in system.rows.items() if rows[-1] >= system.m_holonomic)
            raise SarrusError(
                f"{joint}: {analysis} is not possible with rolling without slip, as {nonholonomic}"
            )
        if not unset:
            refuse_unset(system, drivers_only=analysis in OF_POSITIONS_ONLY)
        return carry(system.warnings)
    call = f"sr.{analysis}(sr.System(model), ...)"
    if isinstance(system, str):
        call = f'sr.{analysis}(sr.System(sr.load("{system}")), ...)'
    raise TypeError(f"{analysis} needs a System, got {kind(system)}. Call {call}.")


def refuse_unset(system: System, *, drivers_only: bool = False) -> None:
    """Refuse a system with an input that has no value; with `drivers_only`, if a driver follows it.

    Raises
    ------
    SarrusError
    """
    for name, quantity in system.inputs.items():
        if not quantity.is_set and (quantity.driving or not drivers_only):
            raise SarrusError(
                f"{system.name}: the input {name} is not set. Give it a value in the model, by "
                f"system.with_inputs({{{name!r}: 0.0}}), or in simulate(..., inputs=...)."
            )


def refuse_for_positions(system: object, analysis: str, why: str = OF_POSITIONS) -> None:
    """Refuse what an analysis of positions cannot have, besides what is no system.

    Raises
    ------
    TypeError
        With the right call.
    SarrusError
        With the first-order states, the blocks of coordinates of parts, or the first of the joints that roll, and `why`
        these are refused.
    """
    states = (*system.states, *system.followed_states) if isinstance(system, System) else ()
    if isinstance(system, System) and states:
        raise SarrusError(
            f"{system.name}: {analysis} is an analysis of positions, but {', '.join(states)} are first-order "
            "states, which follow from a motion. Simulate, or remove the states from the model."
        )
    others = system.layout.moving.owners[len(system.bodies) :] if isinstance(system, System) else ()
    if isinstance(system, System) and others:
        raise SarrusError(
            f"{system.name}: {analysis} is an analysis of positions, but the coordinates of {', '.join(others)} "
            "follow from forces. Simulate, or remove these parts from the model."
        )
    refuse_other_system(system, analysis, nonholonomic=why)


def kind(value: object) -> str:
    """Return a short text for the type of a value."""
    name = type(value).__name__
    return "nothing" if value is None else f"{'an' if name[0] in 'AEIOU' else 'a'} {name}"
