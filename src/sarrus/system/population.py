"""The elements of a system by kind, as arrays: their bodies, equations and numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..algebra import Array
from ..elements import BUILT_IN, Element, Normalization
from ..elements.element import WIDTHS

WIDTH = 7  # coordinates of a body


@dataclass
class Population:
    """All elements of one kind.

    Attributes
    ----------
    kind : the element class
    bodies : (count, 1 or 2) first coordinate of each body, -7 for ground
    rows : (count,) first constraint equation of each element (unused for inertias and forces)
    constraints : (count,) place of each element among all constraint elements
    at : place of the first element's numbers in the system's numbers
    owners, labels : (count,) the part of the model that each belongs to, and what it does there
    """

    kind: type[Element]
    bodies: Array
    values: list[tuple[Any, ...]]
    owners: list[str]
    labels: list[str]
    rows: Array = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    constraints: Array = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    at: int = 0

    @property
    def count(self) -> int:
        return len(self.bodies)

    @property
    def end(self) -> int:
        """Place behind the last element's numbers."""
        return self.at + self.count * self.kind.size()


def populate(placed: Sequence[Any], body_count: int) -> tuple[list[Population], Array]:
    """Sort a blueprint's placed elements by kind, number their equations, add the normalizations, lay out the numbers.

    Returns
    -------
    populations : those of the built-in kinds first, in their fixed order, then the user's own kinds
    numbers : all numbers of all elements, then the curves
    """
    custom = dict.fromkeys(p.element for p in placed if p.element not in BUILT_IN)
    populations = {kind: _population(kind, placed, body_count) for kind in (*BUILT_IN, *custom)}
    _number_equations(populations, placed)
    return list(populations.values()), _lay_out(list(populations.values()))


def _population(kind: type[Element], placed: Sequence[Any], body_count: int) -> Population:
    if kind is Normalization:
        bodies = WIDTH * np.arange(body_count)[:, None]
        names = [""] * body_count
        return Population(kind, bodies, [()] * body_count, names, ["normalization"] * body_count)
    mine = [p for p in placed if p.element is kind]
    bodies = np.array([p.bodies for p in mine], dtype=np.int64).reshape(-1, kind.bodies)
    values, owners, labels = ([getattr(p, n) for p in mine] for n in ("values", "owner", "label"))
    return Population(kind, WIDTH * (bodies - 1), values, owners, labels)


def _number_equations(populations: dict[type[Element], Population], placed: Sequence[Any]) -> None:
    """Joint equations in the order of the model, then the normalizations."""
    found: dict[type[Element], list[tuple[int, int]]] = {kind: [] for kind in populations}
    row = place = 0
    normalized = populations[Normalization].count
    for kind in (*(p.element for p in placed), *[Normalization] * normalized):
        found[kind].append((row, place))
        row += kind.rows
        place += kind.rows > 0
    for kind, population in populations.items():
        table = np.array(found[kind], dtype=np.int64).reshape(-1, 2)
        population.rows, population.constraints = table[:, 0].copy(), table[:, 1].copy()


def _lay_out(populations: list[Population]) -> Array:
    at = 0
    for population in populations:
        population.at = at
        at = population.end
    store: list[float] = []
    flat = [number for p in populations for number in _numbers(p, at, store)]
    return np.array([*flat, *store], dtype=float)


def _numbers(population: Population, end: int, store: list[float]) -> Iterator[float]:
    """The numbers of a population; curves go to the store behind all numbers, and their place is the number."""
    kinds = population.kind.fields.values()
    for values in population.values:
        for kind, value in zip(kinds, values, strict=True):
            if kind == "Curve":
                yield float(end + len(store))
                store.extend(value.numbers())
            elif WIDTHS[kind] > 1:
                yield from (float(v) for v in value)
            else:
                yield float(value)
