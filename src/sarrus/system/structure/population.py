"""The elements of a system by kind, as arrays: their bodies, equations and parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from ...algebra import Array
from ...elements import BUILT_IN, Element, Normalization, recorder
from ...elements.element import ROTATION, WIDTHS, Kind
from ...elements.recorder import Variant, distinct, variants
from ...model import Curve, Formula, ModelError, Surface
from ...model.expansion.blueprint import Placement

STEP = 3  # numbers that a step of a formula is stored as; one more may change the sign of a constant
OTHER = 1.234567e-3  # change of the constants of a formula, which makes all of them different
USUAL = tuple(variant for kind in BUILT_IN for variant in variants(kind))
NONE = np.zeros(0, dtype=np.int64)


@dataclass
class Population:
    """All elements of one variant: of one kind, and with the ground (if any) at the same positions among their bodies.

    Attributes
    ----------
    variant : the element class and the places of the ground
    bodies : (count, moving bodies) first coordinate of each moving body
    rows : (count,) first constraint equation of each element (unused for inertias and forces)
    constraints : (count,) place of each element among all constraint elements
    at : place of the first element's numbers in the system's numbers
    owners, labels : (count,) the part of the model that each belongs to, and what it does there
    """

    variant: Variant
    bodies: Array
    values: list[tuple[Any, ...]]
    owners: list[str]
    labels: list[str]
    rows: Array
    constraints: Array
    at: int = 0

    @property
    def kind(self) -> type[Element]:
        return self.variant.kind

    @property
    def is_force(self) -> bool:
        """Whether these are forces, including weight."""
        return bool(self.kind.family) and self.kind.family[0].family == "force"

    @property
    def count(self) -> int:
        return len(self.bodies)

    @property
    def coordinates(self) -> Array:
        """Indices of the coordinates of the moving bodies of each element (count, n)."""
        parts = [self.bodies[:, [slot]] + np.arange(width) for slot, width in enumerate(self.variant.widths)]
        return np.concatenate([np.zeros((self.count, 0), np.int64), *parts], axis=1)

    @property
    def end(self) -> int:
        """Index behind the last element's parameters."""
        return self.at + self.count * self.kind.size() if self.count else self.at


def populate(placed: Sequence[Placement], firsts: Array) -> tuple[list[Population], Array]:
    """Sort elements by kind, number their equations, and lay out the parameters.

    Parameters
    ----------
    placed : elements
    firsts : first coordinate of each body by number, without the ground

    Returns
    -------
    populations : the usual variants of the common kinds first, in their fixed order, then all others; those of
        nonholonomic constraints, whose equations and parameters are last, at the end
    numbers : all numbers of all elements, then the curves and surfaces
    """
    members: dict[Variant, list[Any]] = {variant: [] for variant in USUAL}
    row = place = 0
    for p in sorted(placed, key=lambda p: p.element.nonholonomic):
        members.setdefault(Variant.of(p.element, p.bodies), []).append((p, row, place))
        row += p.element.rows
        place += p.element.rows > 0
    ordered = sorted(members.items(), key=lambda item: item[0].kind.nonholonomic)
    populations = [_population(variant, found, firsts) for variant, found in ordered]
    return populations, _lay_out(populations)


def normalizations(owners: Mapping[str, Sequence[Kind]]) -> list[Placement]:
    """The normalizations of the Euler parameters of the owners that have some."""
    return [
        Placement(Normalization, (number,), (), "", "normalization")
        for number, kinds in enumerate(owners.values(), 1)
        if ROTATION in kinds
    ]


def _population(variant: Variant, found: list[tuple[Placement, int, int]], firsts: Array) -> Population:
    if not found:
        return Population(variant, _no_bodies(variant.moving), [], [], [], NONE, NONE)
    placed, *places = zip(*found, strict=True)
    rows, constraints = np.array(places, dtype=np.int64)
    bodies = np.array([distinct(p.bodies) for p in placed], dtype=np.int64).reshape(-1, variant.moving)
    values, owners, labels = [p.values for p in placed], [p.owner for p in placed], [p.label for p in placed]
    return Population(variant, firsts[bodies - 1], values, owners, labels, rows, constraints)


@cache
def _no_bodies(moving: int) -> Array:
    return np.zeros((0, moving), dtype=np.int64)


def _lay_out(populations: list[Population]) -> Array:
    at = 0
    for population in populations:
        population.at = at
        at = population.end
    store: list[float] = []
    surfaces: dict[Surface, int] = {}
    flat = [number for p in populations if p.count for number in _numbers(p, at, store, surfaces)]
    assert len(flat) == at, f"{len(flat)} numbers are laid out where {at} have their places"
    return np.array([*flat, *store], dtype=float)


def _numbers(
    population: Population, end: int, store: list[float], surfaces: dict[Surface, int]
) -> Iterator[float]:
    """The parameters of a population; tables are stored behind all parameters, and the parameter is their index.

    Elements on the same surface have it in common. A field that holds the time has no number.
    """
    kinds = [kind for kind in population.kind.fields.values() if kind != "Time"]
    for values in population.values:
        for kind, value in zip(kinds, values, strict=True):
            if kind == "Curve":
                yield float(end + len(store))
                own = value.numbers()
                store.extend(own)
                store.extend([0.0] * (_size(value, own) - len(own)))
            elif kind == "Surface":
                if value not in surfaces:
                    surfaces[value] = end + len(store)
                    store.extend(value.numbers())
                yield float(surfaces[value])
            elif WIDTHS[kind] > 1:
                yield from (float(v) for v in value)
            else:
                yield float(value)


def _size(curve: Curve | Formula, stored: Sequence[float]) -> int:
    """How many numbers a curve takes: a formula all those that it has with other constants.

    Of 0*(...) and 1*(...), or with equal constants, it has fewer steps. Derivatives by its constants have places, too.
    """
    constants = [abs(x) for x in inside(curve)] if isinstance(curve, Formula) else []
    if len({*constants, 0.0, 1.0}) == len(constants) + 2 or isinstance(curve, Curve):
        return len(stored)
    try:
        other = curve.exchanged(lambda n, one: replace(one, number=one.value() + OTHER * (n + 1))).numbers()
    except ModelError:  # it exists at its own constants only
        other = ()
    return max(len(stored), len(other) + STEP * len(constants))


def places_of(
    populations: Sequence[Population], placed: Sequence[Placement], numbers: Array
) -> Iterator[tuple[int, Any]]:
    """For every parameter of the elements of the same model: its index in the parameter vector, and its value.

    Parameters of curves have the indices of `CurveDerivatives`. State variables are left out.
    """
    waiting: dict[Variant, list[Placement]] = {}
    for p in placed:
        waiting.setdefault(Variant.of(p.element, p.bodies), []).append(p)
    for population in populations:
        fields = [kind for kind in population.kind.fields.values() if kind != "Time"]
        for k, p in enumerate(waiting.get(population.variant, ())):
            at = population.at + k * population.kind.size()
            for kind, value in zip(fields, p.values, strict=True):
                if kind == "Curve":
                    yield from ((int(numbers[at]) + n, v) for n, v in enumerate(inside(value)))
                elif kind not in ("Memory", "Surface"):
                    yield from ((at + n, v) for n, v in enumerate(value if WIDTHS[kind] > 1 else (value,)))
                at += WIDTHS[kind]


def inside(curve: Curve | Formula) -> Sequence[Any]:
    """The data of a curve: all stored values of a table, the constants of a formula."""
    if isinstance(curve, Curve):
        return curve.numbers()
    return [number.number for number in curve.written.numbers()] if curve.written else ()


GROUND = np.array(recorder.GROUND, dtype=float)


def local(p: Population, k: int, vector: Array, ground: Array) -> Array:
    """A vector of the system restricted to element k of a population; `ground` replaces the part of the fixed body."""
    return np.concatenate([ground if f < 0 else vector[f : f + width] for f, width in owners(p, k)])


def firsts(p: Population, k: int) -> list[int]:
    """First coordinate of each body of element k, negative for the ground."""
    return [-1 if slot < 0 else int(p.bodies[k, slot]) for slot in p.variant.slots]


def owners(p: Population, k: int) -> Iterator[tuple[int, int]]:
    """First coordinate of each body of element k, negative for the ground, and how many it has."""
    widths = (sum(len(kind.parts) for kind in blocks) for blocks in p.kind.owners())
    return zip(firsts(p, k), widths, strict=True)
