"""Outputs that elements declare: ``spring.tension``, ``tyre.compression``, ``force.torque.z``, and those of users."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from functools import cache, partial
from typing import Any, cast

import numpy as np

from ..algebra import Array
from ..elements import ElementError, Force, Primitive
from ..elements.output import Declared, declared
from ..model.expansion.blueprint import Placement
from ..system import System
from ..system.structure.population import Population
from .output import Level, Output, provides

ADDED = ("W", "J")  # units of what several elements of one part have together
VECTORS = [one for one in declared(Force).values() if one.axes]  # of every force, added on the same bodies
LEVELS = {1: Level.POSITION, 2: Level.VELOCITY, 3: Level.VELOCITY}


@provides
def elements(system: System, part: str | None) -> Iterator[Output]:
    """Return the outputs that the elements of forces and joints declare."""
    found = list(_members(system, part))
    several = Counter((p.owners[k], word) for p, k, _ in found for word in p.kind.outputs)
    together: dict[tuple[str, str, tuple[str, ...]], list[tuple[Population, int, Declared]]] = {}
    for p, k, number in found:
        for one in (*p.kind.outputs.values(), *_beside_scalars(p.kind)):
            name = f"{p.owners[k]}.{one.word}" + f".{number}" * (several[p.owners[k], one.word] > 1)
            together.setdefault((p.owners[k], one.word, one.axes), []).append((p, k, one))
            for n, axis in enumerate(one.axes or ("",)):
                of_position = one.arguments == 1 and not p.kind.timed
                element = partial(_placed, p, k, one, n) if of_position else None
                full, level = f"{name}.{axis}".rstrip("."), LEVELS[one.arguments]
                yield Output(full, one.unit, partial(_record, p, k, one, n), level, element=element)
    for (owner, word, axes), own in together.items():
        one, level = own[0][-1], max(LEVELS[one.arguments] for *_, one in own)
        if len(own) > 1 and (one.unit in ADDED or (one in VECTORS and _on_the_same_bodies(own))):
            for n, axis in enumerate(axes or ("",)):
                yield Output(f"{owner}.{word}.{axis}".rstrip("."), one.unit, partial(_sum, own, n), level)


def _on_the_same_bodies(own: Sequence[tuple[Population, int, Declared]]) -> bool:
    return len({(p.variant.slots, *p.bodies[k]) for p, k, _ in own}) == 1


def _beside_scalars(kind: Any) -> tuple[Declared, ...]:
    """The vectors of every force whose names a class gives to scalars: `coil.torque.x` beside `coil.torque`."""
    own = kind.outputs
    return tuple(one for one in VECTORS if one.word in own and own[one.word].axes != one.axes)


def _members(system: System, part: str | None) -> Iterator[tuple[Population, int, int]]:
    """The elements that have outputs, each with its number among those of its owner; not those of bodies."""
    count = Counter[str]()
    for p in system.populations:
        for k, owner in enumerate(p.owners if p.kind.outputs else ()):
            if part in (None, owner) and owner not in system.bodies:
                count[owner] += 1
                yield p, k, count[owner]


def _record(p: Population, k: int, one: Declared, n: int, o: Any) -> Any:
    found = o.scalars(p, k, one.method, one.arguments)
    if len(found) != (len(one.axes) or 1):
        wanted = "three numbers" if one.axes else "one number"
        raise ElementError(
            f"element {p.kind.__name__}: its output {one.word} must return {wanted}, got {len(found)}. "
            "Return an array of this length."
        )
    return found[n]


def _sum(own: Sequence[tuple[Population, int, Declared]], n: int, o: Any) -> Any:
    return sum(_record(p, k, one, n, o) for p, k, one in own)


def _placed(p: Population, k: int, one: Declared, n: int, system: System) -> Placement:
    """An element that measures an output of another one."""
    bodies = tuple(
        0 if slot < 0 else system.layout.owner_of[p.bodies[k, slot]] + 1 for slot in p.variant.slots
    )
    return Placement(_measuring(cast(Any, p.kind), one.method, n), bodies, p.values[k], p.owners[k], one.word)


@cache
def _measuring(kind: Any, method: str, n: int) -> type[Primitive]:
    """A constraint whose Φ is an output of an element, with all its derivatives."""

    def own(self: Any) -> Any:
        return kind(*(getattr(self, name) for name in kind.fields))

    def Phi(self: Any, x: Any) -> Array:
        return np.ravel(np.array(getattr(own(self), method)(x), dtype=object))[n : n + 1]

    name, methods = (
        f"{kind.__name__}_{method}_{n}",
        {"Phi": Phi, "remember": lambda self, x: own(self).remember(x), "owners": kind.owners},
    )
    body = methods | {"__annotations__": dict(kind.fields), "__module__": kind.__module__}
    options: dict[str, Any] = {"derivatives": "automatic", "rare": True, "registered": False}
    return type(name, (Primitive,), body, rows=1, bodies=kind.bodies, **options)
