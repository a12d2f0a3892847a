"""Names of bodies and joints that a model takes, from those of a description, which may hold anything."""

from __future__ import annotations

import re
from collections.abc import Iterable

from ...model.solid import GROUND


def legal(names: Iterable[str], taken: set[str], ending: str) -> dict[str, str]:
    """Return a name of letters, digits, _ and - for each name; one that is ``taken`` gets the ending, then numbers."""
    found: dict[str, str] = {}
    for name in names:
        found[name] = _free(_plain(name), taken | {GROUND}, ending)
        taken.add(found[name])
    return found


def _plain(name: str) -> str:
    plain = re.sub(r"[^\w-]", "_", name)
    return plain if re.match(r"[^\W\d]", plain) else f"_{plain}"


def _free(name: str, taken: set[str], ending: str) -> str:
    if name not in taken:
        return name
    tries = [f"{name}{ending}", *(f"{name}{ending}{n}" for n in range(2, len(taken) + 3))]
    return next(one for one in tries if one not in taken)
