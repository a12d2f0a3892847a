"""Path of a tendon: the sum of factors times lengths of segments, or times coordinates of joints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from ....algebra import Block, Row, scaled
from ....elements import Pair
from ....elements.element import Scalar
from ...signals import Measure, Measuring
from ..formula_element import along_coordinate

ONE = np.array([1])  # unit load


class PathKind(NamedTuple):
    """The kind of a path: the kinds of its parts, segments or joint coordinates."""

    parts: tuple[Any, ...]

    @property
    def fields(self) -> Mapping[str, str]:
        """The kinds of the fields by name: those of the parts, their factors, and a constant length."""
        found = {
            f"{name}_{n}": kind for n, part in enumerate(self.parts) for name, kind in part.fields.items()
        }
        return found | {f"factor_{n}": "Scalar" for n in range(len(self.parts))} | {"start": "Scalar"}

    def __call__(self, *values: Any) -> Path:
        """Return the path with these values of its fields."""
        at, measures = 0, []
        for part in self.parts:
            measures.append(part(*values[at : at + len(part.fields)]))
            at += len(part.fields)
        return Path(self, measures, values[at:-1], values[-1])


class Path(NamedTuple):
    """A path: its parts, their factors, and a constant length."""

    kind: PathKind
    measures: list[Any]
    factors: tuple[Any, ...]
    start: Any

    @property
    def fields(self) -> Mapping[str, str]:
        """The kinds of the fields by name."""
        return self.kind.fields

    def length(self, x: Any) -> Scalar:
        """The sum of factors times lengths or coordinates."""
        parts = zip(self.measures, self.factors, self._local(x), strict=True)
        return sum((factor * _coordinate(one, own) for one, factor, own in parts), self.start)

    def rate(self, x: Any, v: Any) -> Scalar:
        """Its rate."""
        parts = zip(self.measures, self.factors, self._local(x), self._local(v), strict=True)
        return sum(factor * _rate(one, own, rates) for one, factor, own, rates in parts)

    def gradient(self, x: Any) -> list[Block]:
        """The derivatives of the length to the coordinates of the bodies of all parts, one after the other."""
        found = list[Block]()
        for one, factor, own in zip(self.measures, self.factors, self._local(x), strict=True):
            has_act = hasattr(one, "act")
            unit = one.act(ONE, own, own, 0) if has_act else along_coordinate(one, ONE, own, own, 0)
            found += [scaled(factor, block) for block in unit]
        return found

    def act(self, values: Any, x: Any, v: Any, t: Scalar) -> Row:
        """Q of a force that increases the length if it is positive."""
        return tuple(scaled(values[0], block) for block in self.gradient(x))

    def remember(self, x: Any) -> tuple[Scalar, ...]:
        """New values of the memory fields of all parts at an accepted state."""
        pairs = zip(self.measures, self._local(x), strict=True)
        return tuple(
            value for one, own in pairs if "Memory" in one.fields.values() for value in one.remember(own)
        )

    def _local(self, x: Any) -> Iterator[Any]:
        """Coordinates, or rates, of the bodies of each part."""
        at, blocks = 0, tuple(x)
        for part in self.kind.parts:
            own = blocks[at : at + 2 * part.bodies]
            at += 2 * part.bodies
            yield Pair(*own) if part.bodies == 2 else own


class Pull(NamedTuple):
    """A force along a path; further laws are outputs of the part."""

    outputs: tuple[tuple[str, str], ...]

    def __call__(self, of: Path, values: Any, x: Any, v: Any, t: Scalar) -> Row:
        """Q of the first value."""
        return of.act(values, x, v, t)


def _coordinate(of: Any, x: Any) -> Scalar:
    return of.length(x) if hasattr(of, "act") else of.Phi(x)[0]


def _rate(of: Any, x: Any, v: Any) -> Scalar:
    return of.rate(x, v) if hasattr(of, "act") else of.Phi_q_xi(x, v)[0]


def path_of(measures: list[Measure], factors: list[Any], start: Any) -> Measure:
    """Return the measure of a path with factors of its parts, and a constant length."""
    kinds: tuple[Measuring, ...] = tuple(one.kind for one in measures)
    values = [value for one in measures for value in one.values]
    bodies = tuple(body for one in measures for body in one.bodies)
    return Measure(PathKind(kinds), bodies, (*values, *factors, start))
