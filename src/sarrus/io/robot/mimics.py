"""Joints that follow another joint: where they start, which stand still, and what couples the others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ...model import Coupler, FormulaCoupler, Joint
from ...model.errors import ModelError
from ...model.expression import Name
from ...model.quantity import Array
from ...model.show import quote
from ..plurals import counted
from .description import Description, Mimic, legal
from .tree.coordinates import Coordinates, Found

REMEDY = 'Import it with mimic="free" or mimic="lock".'


def followers(description: Description, values: Mapping[str, Array]) -> dict[str, Array]:
    """Return where the following joints start, unless a value is given for them."""
    found = dict(values)
    for name in description.mimics:
        _follow(name, description.mimics, found)
    return found


def standing(mimics: Mapping[str, Mimic], locked: set[str]) -> set[str]:
    """Return the joints that follow one that does not move, or follow by nothing."""
    still = set(locked)
    for _ in mimics:
        still |= {name for name, mimic in mimics.items() if mimic.joint in still or mimic.is_constant()}
    return still


def couplers(description: Description, coordinates: Coordinates, taken: set[str]) -> Iterator[Joint]:
    """Yield a coupler for each following joint that moves.

    Raises
    ------
    ModelError
        If the value of a joint cannot be computed because it is part of a combined joint.
    """
    moving = {name: mimic for name, mimic in description.mimics.items() if name in coordinates.edges}
    names = legal([f"{name}_mimic" for name in moving], taken, "_coupler")
    for (name, mimic), made in zip(moving.items(), names.values(), strict=True):
        try:
            leader, follower = (coordinates.find(motion, REMEDY) for motion in (mimic.joint, name))
        except ModelError as error:
            where = description.where(coordinates.edges[name].line)
            raise ModelError(error.message, part=f"joint {quote(name)}", where=where) from None
        yield _coupler(made, leader, follower, mimic)


def _coupler(name: str, leader: Found, follower: Found, mimic: Mimic) -> Joint:
    if not any(mimic.higher):
        ratio = mimic.multiplier * leader.sign * follower.sign
        return Coupler(name, leader.name, follower.name, ratio, mimic.offset * follower.sign)
    factors = [mimic.offset, mimic.multiplier, *mimic.higher]
    parameters = {f"a{n}": a * follower.sign * leader.sign**n for n, a in enumerate(factors) if a}
    powers = (word if word == "a0" else f"{word}*{Name(leader.name)}^{word[1:]}" for word in parameters)
    return FormulaCoupler(name, follower.name, value=" + ".join(powers), parameters=parameters)


def freed(description: Description, locked: set[str]) -> list[str]:
    """Return the message on how many following joints move independently."""
    n = len(set(description.mimics) - locked)
    return (
        [counted("{n} [joint that follows another moves|joints that follow another move] freely", n)]
        if n
        else []
    )


def _follow(name: str, mimics: Mapping[str, Mimic], found: dict[str, Array]) -> Array:
    if name not in found:
        found[name] = np.zeros(1)
        if name in mimics:
            leader, multiplier, offset, higher = mimics[name]
            value, factors = _follow(leader, mimics, found), (offset, multiplier, *higher)
            found[name] = sum((a * value**n for n, a in enumerate(factors)), np.zeros(1))
    return found[name]
