"""The first switch of a force within a step, and the step that ends just before it.

Switching functions are evaluated at ten times of a step: at five places, and a little beside each for their rates. One
that comes near to zero and reverses between two places is searched more closely; one that comes and goes unseen is
missed. The first change is located by bisection on the interpolated step, and the step is taken again up to it, a few
times by Newton's method, because the step that passed the switch contains it. Tables are smooth where their parts end:
steps end there only before a part that is shorter than half a step, which they might not see.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ...._jit.formulas.curves import curve_value
from ...._jit.kernels.pointer import KernelTable, call_kernels
from ...._jit.kernels.scalars import Scalars
from ...._jit.linking.link import compiled
from ....algebra import Array
from ..inputs.laws_of_time import ASIDE
from ..stepping.nodes import between

NEAR = 1e-10  # of a step: so long before a switch a step ends, and so long behind it the next one begins
BESIDE = 1e-6  # of a step: between two states that give the rate of a function
BISECTIONS = 36  # of a quarter of a step
DIVISIONS = 24  # of the same, towards the least distance of a function from zero
SEARCHES = 16  # times a step to a switch is taken again
FURTHER = 4.0  # times further back each time that a step ends beyond a switch, whose force holds it there
ROUND_OFF = 1e-12  # of the size of its terms: what integration leaves of a function that decays to zero
SHIFT = 1e-6  # of the states, at random: the change of a function shows the size of its terms
FIRST = 0.1  # of the time within which a force sets in and ends: the first step after it has set in
STEPS_BEFORE, REST = 3, 0.25  # shorter steps before a switch, and how much is left after each; see `shorter`
FAR = 1.5  # times what is left: nearer to a switch no such step ends
RESOLVED = 2  # steps since the last switch: where there are fewer they are short already
FIVE, LOW, HIGH, AHEAD = 5, 5, 6, 7  # places of a step, and rows of values behind theirs
NONE, SEARCHING, LANDED = 0, 1, 2


class Switching(NamedTuple):
    """The switching functions of a system, compiled, and arrays to work on.

    Attributes
    ----------
    entry : kernels of the arguments of forces
    columns, forces : places of a function's argument, and of the square of its force, among those (n,)
    formulas : where the formula of the argument is in `numbers` whose value the function is; negative for none (n,)
    numbers : of these formulas
    starts, parts, first, period : tables: where the inner ends of the parts of each are in `parts` (n + 1,), these
        ends, its first point and its period (infinite: none; 0: no table) (n,)
    returns : whether a run begins anew at a switch (n,)
    near : whether ever shorter steps come before a switch (1,)
    shifts : random changes of q and v (3, 2, nq)
    arguments, value, mode, acts, rate : at places of a step, in rows
    changes, ignored : functions that change between two places, and those that end no step (n,)
    q, v, a : an interpolated state
    """

    entry: KernelTable
    columns: Array
    forces: Array
    formulas: Array
    numbers: Array
    starts: Array
    parts: Array
    first: Array
    period: Array
    returns: Array
    near: Array
    shifts: Array
    arguments: Array
    value: Array
    mode: Array
    acts: Array
    rate: Array
    changes: Array
    ignored: Array
    q: Array
    v: Array
    a: Array


class Step(NamedTuple):
    """A step: the parameters b during it, its begin, its length, and the states at both ends.

    It is interpolated between these, `apart` or not, see `between`.
    """

    b: Array
    t: float
    h: float
    q0: Array
    v0: Array
    a0: Array
    q1: Array
    v1: Array
    a1: Array
    apart: bool


class Crossing(Scalars):
    """The switch at which a step is to end.

    Attributes
    ----------
    stage : `NONE`, `SEARCHING` or `LANDED`
    number : of the function
    back : how much shorter the next one is if a step ends beyond it [s]
    tries, nearer : steps taken to it, and shorter ones before
    rest : what the last of these left [s]
    level, before : the value of the function there, and its sign before it
    part : of the step that passed it
    h : length of that step [s]
    stays : how long the function stays beyond it, if it comes back within that step, else infinite [s]
    left : from the end of a step to it [s]
    since : steps since the last one
    begun, lasts : when a step last ended at a function that comes back, and how long that one stays beyond it [s]
    """

    stage: int
    number: int
    back: float
    tries: int
    nearer: int
    rest: float
    level: float
    before: float
    part: float
    h: float
    stays: float
    left: float
    since: int
    begun: float
    lasts: float


@compiled
def first_after(crossing: Crossing) -> float:
    """The first step after a switch at most, where the method does not begin anew [s]."""
    return FIRST * min(crossing.stays, (1.0 - crossing.part) * crossing.h)


@compiled
def width(t: float, h: float) -> float:
    """The distance from a switch at which a step ends [s]."""
    return max(NEAR * h, ASIDE * abs(t))


@compiled
def evaluate(sw: Switching, b: Array, t: float, q: Array, v: Array, row: int) -> None:
    """All functions at a state, their modes, which change by 1 at least, and whether their forces act."""
    call_kernels(sw.entry, b, t, q, v, sw.arguments)
    for k in range(len(sw.columns)):
        x = sw.arguments[sw.columns[k]]
        if sw.formulas[k] >= 0:
            x = curve_value(sw.numbers, sw.formulas[k], x)
        sw.value[row, k] = x
        sw.acts[row, k] = sw.arguments[sw.forces[k]] != 0.0
        if sw.period[k] == 0.0:
            sw.mode[row, k] = 0.5 if x > 0.0 else -0.5 if x < 0.0 else 0.0
        else:
            periods = math.floor((x - sw.first[k]) / sw.period[k]) if sw.period[k] < math.inf else 0.0
            if sw.period[k] < math.inf:
                x -= periods * sw.period[k]
            low, high = sw.starts[k], sw.starts[k + 1]
            while low < high:
                middle = (low + high) // 2
                if x < sw.parts[middle]:
                    high = middle
                else:
                    low = middle + 1
            sw.mode[row, k] = low - sw.starts[k] + periods * (sw.starts[k + 1] - sw.starts[k] + 1)
            sw.acts[row, k] = 1.0


@compiled
def evaluate_at(sw: Switching, step: Step, part: float, row: int) -> None:
    """The same at a part of a step."""
    time = step.t + part * step.h
    if part == 1.0:
        evaluate(sw, step.b, time, step.q1, step.v1, row)
        return
    between(step.q0, step.v0, step.a0, step.q1, step.v1, step.a1, part, step.h, step.apart, sw.q, sw.v, sw.a)
    evaluate(sw, step.b, time, sw.q, sw.v, row)


@compiled
def changed(sw: Switching, k: int, one: int, other: int) -> bool:
    """Whether a function has another mode in another row."""
    return bool(abs(sw.mode[one, k] - sw.mode[other, k]) >= 1.0)


@compiled
def passes(sw: Switching, k: int, n: int) -> bool:
    """Whether a function changes between two places; a table: whether a part within half a step begins there."""
    change = abs(sw.mode[n, k] - sw.mode[n + 1, k])
    if sw.period[k] == 0.0:
        return bool(change >= 1.0)
    return bool(change > 0.0 and max(change, abs(sw.mode[n, k] - sw.mode[min(n + 2, FIVE - 1), k])) >= 2.0)


@compiled
def place(n: int, begin: float) -> float:
    """The parts of a step at which functions are evaluated."""
    return 0.25 * n if n else begin


@compiled
def look(sw: Switching, step: Step, begin: float) -> None:
    """Functions and their rates, by parts of the step, at five places of it."""
    for n in range(FIVE):
        part = place(n, begin)
        beside = part - BESIDE if n == FIVE - 1 else part + BESIDE
        evaluate_at(sw, step, beside, LOW)
        evaluate_at(sw, step, part, n)
        for k in range(len(sw.columns)):
            if n > 0 and sw.period[k] == 0.0 and sw.value[n, k] == 0.0 and sw.value[LOW, k] != 0.0:
                sw.mode[n, k] = sw.mode[n - 1, k]  # it changes behind a single place at which it is zero
            sw.rate[n, k] = (sw.value[LOW, k] - sw.value[n, k]) / (beside - part)


@compiled
def dips(sw: Switching, k: int, n: int, size: float) -> bool:
    """Whether a function reverses between two places, where it comes near to zero."""
    x, y, down, up = sw.value[n, k], sw.value[n + 1, k], sw.rate[n, k], sw.rate[n + 1, k]
    if not (x * y > 0.0 and x * down < 0.0 and y * up > 0.0):
        return False
    return not x * (x + down * (y - x - up * size) / (down - up)) > 0.0  # where tangents meet


@compiled
def beyond(sw: Switching, step: Step, k: int, n: int, low: float, high: float) -> float:
    """The part of a step at which a function that comes near to zero is beyond it, and its force acts; 0 if none."""
    for _ in range(DIVISIONS):
        middle = 0.5 * (low + high)
        evaluate_at(sw, step, middle, LOW)
        if changed(sw, k, n, LOW) and sw.acts[LOW, k] != 0.0:
            return middle
        evaluate_at(sw, step, middle + BESIDE * (high - low), HIGH)
        if (sw.value[HIGH, k] - sw.value[LOW, k]) * sw.value[n, k] < 0.0:
            low = middle
        else:
            high = middle
    return 0.0


@compiled
def changing(sw: Switching, one: int, other: int) -> int:
    """The first function among those that change between two places that has another mode in another row; or -1."""
    for k in range(len(sw.columns)):
        if sw.changes[k] != 0.0 and changed(sw, k, one, other):
            return k
    return -1


@compiled
def first_between(sw: Switching, step: Step, n: int, begin: float, crossing: Crossing) -> bool:
    """Locate the first switch between two places; false if there is none."""
    low, high, top, found = place(n, begin), place(n + 1, begin), place(n + 1, begin), False
    for k in range(len(sw.columns)):
        sw.changes[k] = 0.0
        if sw.ignored[k] != 0.0:
            continue
        if sw.acts[n, k] + sw.acts[n + 1, k] != 0.0 and passes(sw, k, n):
            sw.changes[k], found = 1.0, True
        elif sw.period[k] == 0.0 and dips(sw, k, n, top - low):
            part = beyond(sw, step, k, n, low, top)
            if part > 0.0:
                sw.changes[k], high, found = 1.0, min(high, part), True
    if not found:
        return False
    lowest = high
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        evaluate_at(sw, step, middle, LOW)
        if changing(sw, n, LOW) >= 0:
            high = middle
        else:
            low = middle
    evaluate_at(sw, step, high, HIGH)
    k = crossing.number = changing(sw, n, HIGH)
    if k < 0:
        return False
    crossing.part, crossing.h, crossing.stays = high, step.h, math.inf
    crossing.level = 0.0 if sw.period[k] == 0.0 else sw.value[HIGH, k]
    side = sw.mode[n, k] if sw.period[k] == 0.0 else sw.value[n, k] - crossing.level
    crossing.before = math.copysign(1.0, side)
    for row in range(FIVE - 1, n + 1, -1):
        if changed(sw, k, row, HIGH):
            crossing.stays = 0.5 * (place(row, begin) - high) * step.h
    if not changed(sw, k, n, n + 1):
        crossing.stays = 2.0 * (lowest - high) * step.h
    return True


@compiled
def counts(sw: Switching, step: Step, n: int, begin: float, crossing: Crossing) -> bool:
    """Whether a step is to end at a switch: not at its end.

    Nor where the function is zero but for round-off on one side: u - a, once a has come to u.
    """
    if crossing.part > 1.0 - begin:
        return False
    k, before, behind = crossing.number, 0.0, 0.0
    for row in range(FIVE):
        x = abs(sw.value[row, k])
        before, behind = max(before, x if row <= n else 0.0), max(behind, x if row > n else 0.0)
    for shift in range(0 if sw.period[k] else len(sw.shifts)):
        for i in range(len(sw.q)):
            sw.q[i] = step.q1[i] + sw.shifts[shift, 0, i] * abs(step.q1[i])
            sw.v[i] = step.v1[i] + sw.shifts[shift, 1, i] * (abs(step.v1[i]) + abs(step.q1[i]) / step.h)
        evaluate(sw, step.b, step.t + step.h, sw.q, sw.v, AHEAD)
        if min(before, behind) < ROUND_OFF / SHIFT * abs(sw.value[AHEAD, k] - sw.value[FIVE - 1, k]):
            return False
    return True


@compiled
def first_crossing(sw: Switching, step: Step, crossing: Crossing) -> bool:
    """Locate the first switch within a step; false if there is none."""
    begin, n = min(10.0 * width(step.t, step.h) / step.h, 0.1), 0
    look(sw, step, begin)
    while n < FIVE - 1:
        if not first_between(sw, step, n, begin, crossing):
            n += 1
        elif counts(sw, step, n, begin, crossing):
            return True
        else:
            sw.ignored[crossing.number] = 1.0
    return False


@compiled
def farther_back(crossing: Crossing, h: float) -> float:
    """The length of a step in the place of one that ends beyond a switch, or has no solution near a jump; 0 if none."""
    if crossing.stage != SEARCHING or crossing.tries >= SEARCHES:
        crossing.stage = NONE
        return 0.0
    crossing.tries += 1
    crossing.back *= FURTHER
    return max(h - crossing.back, 0.5 * h)


@compiled
def without(sw: Switching, crossing: Crossing) -> float:
    """The length of the step that passed the switch, which is to be taken as it was: no step can end there."""
    crossing.stage, sw.ignored[crossing.number] = NONE, 1.0
    return crossing.h


@compiled
def shorter(sw: Switching, step: Step, crossing: Crossing) -> float:
    """The length of a step that is to be taken in the place of this one, towards the first switch; 0 if it may stay.

    The time of a switch depends on parameters, and the error of the last step on where in it the switch is: in one
    long step derivatives have far fewer digits than states. Where these are wanted, `near`, ever shorter steps come
    before it, unless it is near to the begin of the step.
    """
    h, wide = step.h, width(step.t, step.h)
    if crossing.stage == NONE:
        if not first_crossing(sw, step, crossing):
            return 0.0
        way = crossing.part * h
        near = sw.near[0] and sw.period[crossing.number] == 0.0
        while near and crossing.since >= RESOLVED and crossing.nearer < STEPS_BEFORE:
            crossing.rest = REST * (crossing.rest if crossing.nearer else h)
            crossing.nearer += 1
            if way > FAR * crossing.rest:
                return way - crossing.rest
        crossing.stage, crossing.tries, crossing.back = SEARCHING, 0, BESIDE * h
        return max(way - 2.0 * wide, 0.5 * way)
    k = crossing.number
    evaluate_at(sw, step, 1.0 - BESIDE, LOW)
    evaluate_at(sw, step, 1.0, HIGH)
    rate = abs(sw.value[HIGH, k] - sw.value[LOW, k]) / (BESIDE * h)
    crossing.left = crossing.before * (sw.value[HIGH, k] - crossing.level) / rate
    if 0.0 < crossing.left < 4.0 * wide:
        crossing.stage, crossing.nearer, end = LANDED, 0, step.t + h
        if crossing.stays < math.inf:
            crossing.begun, crossing.lasts = end, crossing.stays
        elif 0.0 <= end - crossing.begun < crossing.lasts:  # the rounding of a force that ends soon
            crossing.stays = crossing.lasts
        return 0.0
    length = h + crossing.left - 2.0 * wide
    if crossing.tries < SEARCHES and length < 2.0 * crossing.h:
        if crossing.left <= 0.0:
            crossing.back = max(-crossing.left, wide)
            return farther_back(crossing, h)
        crossing.tries += 1
        return length
    return without(sw, crossing)
