"""Equalities of tendons: constraints on sums of joint coordinates, and rods."""

from __future__ import annotations

from collections.abc import Iterator

from ....model import Distance, FormulaCoupler, Joint
from ....model.errors import ModelError
from ....model.expression import Name
from ....model.show import quote
from ..description import Description, Path, TendonEquality, legal
from ..tree.coordinates import Coordinates, Laid

REMEDY = 'Import it with ignore=["equalities"].'


def tendon_constraints(
    description: Description, coordinates: Coordinates, taken: set[str]
) -> Iterator[Joint]:
    """Yield a constraint for each equality of a tendon that can move."""
    names = legal(description.equalities, taken, "_equality")
    for name, given in description.equalities.items():
        try:
            yield from _constraint(names[name], given, coordinates)
        except ModelError as error:
            raise ModelError(error.message, part=f"equality {quote(name)}") from None


def _constraint(name: str, given: TendonEquality, coordinates: Coordinates) -> Iterator[Joint]:
    laid = coordinates.lay(given.path, REMEDY)
    if laid is None:
        return
    if given.path.points:
        i, j = laid.fields["points"]
        yield Distance(name, point_i=i, point_j=j, length=given.start + given.factors[0])
        return
    parameters = {f"a{n}": a for n, a in enumerate(given.factors) if a}
    other = _sum(given.other, coordinates) if given.other else "0"
    powers = (word if word == "a0" else f"{word}*({other})^{word[1:]}" for word in parameters)
    (first, factor), *rest = laid.fields["joints"].items()
    value = " + ".join(powers) or "0"
    value = "".join(
        [value, *(f" - ({c!r})*{Name(one)}" for one, c in rest), f" - ({_fixed(given.path, laid)!r})"]
    )
    yield FormulaCoupler(name, first, value=f"({value})/({factor!r})", parameters=parameters)


def _sum(path: Path, coordinates: Coordinates) -> str:
    laid = coordinates.lay(path, REMEDY)
    if laid is None:
        return "0"
    terms = (f"({factor!r})*{Name(name)}" for name, factor in laid.fields["joints"].items())
    return f"{' + '.join(terms)} + ({_fixed(path, laid)!r})"


def _fixed(path: Path, laid: Laid) -> float:
    """What joints that do not move add to the sum."""
    return laid.start - path.start
