"""Names of bodies and joints that a model takes, from those of a description, which may hold anything."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from itertools import count

from ...model.bodies.solid import GROUND


def legal(names: Iterable[str], taken: set[str], ending: str) -> dict[str, str]:
    """Return a name of letters, digits, _ and - for each name; one that is ``taken`` gets the ending, then numbers."""
    found: dict[str, str] = {}
    tried: dict[str, Iterator[str]] = {}
    for name in names:
        plain = _plain(name)
        tries = tried.setdefault(plain, _tries(plain, ending))
        found[name] = next(one for one in tries if one not in taken and one != GROUND)
        taken.add(found[name])
    return found


def _plain(name: str) -> str:
    plain = re.sub(r"[^\w-]", "_", name)
    return plain if re.match(r"[^\W\d]", plain) else f"_{plain}"


def _tries(name: str, ending: str) -> Iterator[str]:
    yield from (name, f"{name}{ending}")
    yield from (f"{name}{ending}{n}" for n in count(2))
