"""Starts as files write them: given rates of joints, or a state of a saved run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ...model import ModelError, SarrusError
from ...model.expression.quantity import quantity
from ...model.quantity import number
from ...model.show import show
from ...results import Assembly, State, load_run
from ...results.saving.saved import UNFINISHED
from ...system import System
from .assembly import assemble
from .joint_space import JointRate, rate

KEYS = ("rates", "equilibrium", "run", "t")


def named_start(system: System, given: Mapping[str, Any]) -> Assembly | State:
    """The start that ``{"rates": {"pin": 5.0}, "t": 0.0}`` or ``{"run": "drop.sarrus", "t": 2.0}`` means.

    Parameters
    ----------
    system : System
    given : `rates` of joints and coordinates, with which the model's own state is assembled at the time `t`, or, with
        ``{"equilibrium": True}``, the equilibrium near it; or a `run`, the folder of a saved run, whose final state or
        state at the time `t` is taken

    Raises
    ------
    ModelError
        For other keys, unknown joints, and rates that are no numbers or in another unit.
    SarrusError
        If there is no such run, or no state at that time was saved.
    """
    for key in given:
        if key not in KEYS:
            raise ModelError(f"start: there is no key {key!r}. Give rates, equilibrium, run or t.")
    if "run" in given:
        return _saved(given)
    rates = given.get("rates", {})
    if not isinstance(rates, Mapping):
        raise ModelError(f'start: rates must be a mapping such as {{"pin": 5.0}}, but is {show(rates)}.')
    values = {str(name): _rate(system, str(name), value) for name, value in rates.items()}
    if not _is_settled(given):
        return assemble(system, t=_time(given), rates=values)
    from ..equilibria.statics import equilibrium  # which itself starts from what names mean

    rest = equilibrium(system, t=_time(given))
    found = assemble(system, rest.q, rest.v, t=rest.t, rates=values)
    if not rest.success:
        return replace(found, success=False, message=rest.message)
    found = replace(found, memory=rest.memory, revolutions=rest.revolutions)
    return replace(found, settled=True, lam=rest.lam) if found.success else found


def _is_settled(given: Mapping[str, Any]) -> bool:
    value = given.get("equilibrium", False)
    if not isinstance(value, bool) and value not in ("true", "false"):
        raise ModelError(f"start: equilibrium must be true or false, but is {show(value)}.")
    return value in (True, "true")


def _saved(given: Mapping[str, Any]) -> State:
    """The final state of a saved run, or that at the time t."""
    if "rates" in given:
        raise ModelError("start: run and rates contradict each other. Give one of them.")
    run = load_run(str(given["run"]))
    if "t" in given:
        try:
            return run.state(_time(given))
        except ValueError as wrong:
            raise ModelError(f"start: {wrong}") from None
    if run.final is None or run.status in UNFINISHED:
        raise SarrusError(f"start: the run {given['run']} has not ended. Give the time t of a saved state.")
    return run.final


def _time(given: Mapping[str, Any]) -> float:
    value = given.get("t", 0.0)
    return _quantity("t", value, "s") if isinstance(value, str) else number(value, "start: t")


def _rate(system: System, name: str, value: Any) -> float:
    """A given rate in SI units."""
    try:
        found = rate(system, name)
    except KeyError as wrong:
        raise ModelError(f"start: {wrong.args[0]}.") from None
    if not isinstance(value, str):
        return number(value, f"start: rates: {name}")
    if isinstance(found, JointRate):
        every = system.joint_coordinates
        return _quantity(name, value, "rad/s" if every.angles[every.index(found.coordinate.name)] else "m/s")
    return _quantity(name, value, "m/s" if ".r." in system.coordinate_names[found.place] else "1/s")


def _quantity(name: str, text: str, unit: str) -> float:
    """A text such as ``30 deg/s``."""
    try:
        return quantity(text, unit)
    except ModelError as wrong:
        raise ModelError(f"start: {name} {wrong.message}") from None
