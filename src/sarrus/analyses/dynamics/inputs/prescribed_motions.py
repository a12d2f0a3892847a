"""Prescribed motions within a run: jumps, which are warnings, and infinite rates, which are refused."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from ....model import Formula, ModelError
from ....system import System
from ....system.cached import once
from .laws_of_time import ASIDE, SAMPLES, Law, fields_of_time, formula_law, parts_of

QUANTITIES = "value", "rate", "acceleration"
JUMP = 1e-6  # of a prescribed motion: smaller changes at a corner are those of its rate
CLOSER = 4.0  # two distances from a time at which derivatives are compared
GROWTH = (
    1.01  # of a derivative at the nearer one: those of t^p grow by 4^-p, finite ones by 1 within round-off
)


def motion_jumps(system: System, begin: float, until: float) -> Iterator[str]:
    """Yield a warning for each driver whose prescribed motion jumps within a run: no force can follow it."""
    for owner, law in _motions(system):
        for t, jump in _jumps(law, begin, until):
            yield (
                f"{owner}: its motion jumps by {jump:.3g} at t = {t:.6g} s, which no velocity and no force can "
                "follow. Give it a rise that takes a time, as by step(t, ...)."
            )


def refuse_infinite_motions(system: System, begin: float, until: float) -> None:
    """Refuse prescribed motions whose value or rate is not finite in a run, or the acceleration at its start.

    Raises
    ------
    ModelError
    """
    for owner, law in _motions(system):
        if fault := _fault(law, begin, until):
            raise ModelError(
                f"{owner}: its motion has no finite {fault[0]} at t = {fault[1]:.6g} s. Choose other times, or a "
                "motion that is smooth there."
            )


@once
def _motions(system: System) -> tuple[tuple[str, Law], ...]:
    """The formulas and Python functions of the time by which drivers prescribe coordinates, with their parts."""
    constraints = [
        (p, n) for p in system.populations if p.count and p.kind.rows for n in fields_of_time(p.variant)
    ]
    values = ((owner, own[n]) for p, n in constraints for owner, own in zip(p.owners, p.values, strict=True))
    return tuple((owner, formula_law(law)) for owner, law in values if isinstance(law, Formula))


def _jumps(law: Law, begin: float, until: float) -> Iterator[tuple[float, float]]:
    """Yield where a law over the time jumps within a run, and by how much."""
    parts = parts_of(law, begin, until)
    for t in parts.corners:
        before, behind = law(t + ASIDE * max(abs(begin), abs(until)) * np.array([-1, 1]))
        if begin < t < until and abs(behind - before) > JUMP * parts.spread:
            yield float(t), float(behind - before)


@lru_cache
def _fault(law: Law, begin: float, until: float) -> tuple[str, float] | None:
    """The quantity that is not finite, and when, if there is one."""
    times, spread = np.linspace(begin, until, SAMPLES), parts_of(law, begin, until).spread
    if len(wrong := times[~np.isfinite(law(times))]):
        return QUANTITIES[0], float(wrong[0])
    for t in (begin, *np.concatenate(law.zeros(times))):
        for order, quantity in enumerate(QUANTITIES if t == begin else QUANTITIES[:2]):
            if _is_infinite(law, float(t), order, begin, until, spread):
                return quantity, float(t)
    return None


def _is_infinite(law: Law, t: float, order: int, begin: float, until: float, spread: float) -> bool:
    """Whether a derivative grows without limit on one side of a time."""
    aside = ASIDE * max(abs(begin), abs(until))
    near = abs(law(t + aside * np.array([[-1, -CLOSER], [1, CLOSER]]).ravel(), order)).reshape(2, 2)
    large = near[:, 0] * (until - begin) ** order > spread  # than on average; others are round-off
    inside = np.array([t - CLOSER * aside > begin, t + CLOSER * aside < until])
    return bool(np.any(inside & large & (near[:, 0] > GROWTH * near[:, 1])))
