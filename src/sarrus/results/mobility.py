"""The result of the rank analysis: degrees of freedom, redundant constraints, remaining motions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from ..algebra import Array
from ..model.deprecated import with_former_names
from .result import Result

Kind = Literal["regular", "redundant", "branching", "shaky", "untested"]


@dataclass(frozen=True)
class Repetition:
    """Equations of one joint that follow from other joints' equations.

    Attributes
    ----------
    joint : whose equations they are
    repeats : names of the joints from which they follow, in the model's order
    rows : their places in Φ
    directions : what each restrains, for example "rotation about x"
    whole : whether these are all equations of the joint
    """

    joint: str
    repeats: tuple[str, ...]
    rows: tuple[int, ...]
    directions: tuple[str, ...]
    whole: bool

    def __str__(self) -> str:
        others = _listed(self.repeats) if self.repeats else "what is fixed already"
        what = "all that it restrains, " if self.whole and len(self.rows) > 1 else ""
        return f"{self.joint} repeats {others}: {what}{_grouped(self.directions)}"


@with_former_names
@dataclass(frozen=True)
class Mobility(Result):
    """Degrees of freedom and redundant constraints of a system in one position.

    Attributes
    ----------
    name : of the system
    coordinates, equations, rank : size of Φ_q and its rank
    degrees_of_freedom : coordinates minus rank: the motions that are possible at this instant
    kind : "regular": independent equations. "redundant": equations that remain dependent along every motion, by the
        second-order test. "branching": several motions meet here. "shaky": a motion is possible for an instant only.
        "untested": too large for the second-order test.
    finite : degrees of freedom of finite motions; None if they branch or were not tested
    repetitions : dependent equations by joint
    independent_rows : indices in Φ of well-conditioned independent equations (rank,)
    null_vectors : (equations, equations - rank) combinations of equations whose gradients vanish
    motions : (coordinates, degrees_of_freedom) an orthonormal basis of the possible velocities
    smallest : smallest nonzero singular value, with every equation scaled to a unit gradient
    configuration_dimension : with nonholonomic constraints, of how many coordinates positions consist; None without
    """

    name: str
    coordinates: int
    equations: int
    rank: int
    degrees_of_freedom: int
    kind: Kind
    finite: int | None
    repetitions: tuple[Repetition, ...]
    independent_rows: Array = field(repr=False)
    null_vectors: Array = field(repr=False)
    motions: Array = field(repr=False)
    smallest: float
    configuration_dimension: int | None = None

    @property
    def redundant(self) -> int:
        """Number of dependent equations."""
        return self.equations - self.rank

    def summary(self) -> str:
        """The result in words."""
        return "\n".join([f"{self.name}: {self._motion()}", *self._counts(), *map(str, self.repetitions)])

    def _motion(self) -> str:
        n = self.degrees_of_freedom
        freedom = f"{n} degree{'' if n == 1 else 's'} of freedom"
        if self.kind == "shaky":
            return f"{freedom} for an instant only: second order lets no more than {self.finite} go on"
        if self.kind == "branching":
            return (
                f"{freedom} at this position only: motions cross or touch here, and there are fewer elsewhere"
            )
        if self.configuration_dimension is not None:
            freedom += f" of the velocities, {self.configuration_dimension} of the positions"
        return freedom + (", whether they go on was not tested" if self.kind == "untested" else "")

    def _counts(self) -> list[str]:
        count = f"{self.coordinates} coordinates, {self.equations} equations (Euler parameters' unit lengths included)"
        message = f", {self.redundant} of them redundant" if self.redundant else ", all independent"
        return [count + message]


def _listed(names: tuple[str, ...]) -> str:
    return names[0] if len(names) == 1 else ", ".join(names[:-1]) + " and " + names[-1]


def _grouped(directions: tuple[str, ...]) -> str:
    """ "displacement along x, displacement along y, rotation about z" with each kind named once."""
    groups: dict[str, list[str]] = {}
    for direction in directions:
        for word in (" along ", " about "):
            if word in direction:
                kind, axis = direction.split(word, 1)
                groups.setdefault(kind + word, []).append(axis)
                break
        else:
            groups.setdefault(direction, [])
    return ", ".join(
        kind + _listed(tuple(sorted(set(axes), key=lambda axis: (len(axis), axis)))) if axes else kind
        for kind, axes in groups.items()
    )
