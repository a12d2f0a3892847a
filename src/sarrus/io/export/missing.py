"""Parts of a model that a format does not have."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ...model.errors import ModelError, listed
from ...model.show import quote


class Gap(NamedTuple):
    """What a format does not have, and the names of the parts to leave out for it."""

    what: str
    names: tuple[str, ...]


class NotInFormat(ModelError):
    """The error for a part that a format does not have."""

    def __init__(self, missing: Gap) -> None:
        super().__init__(missing.what, part=missing.names[0])
        self.missing = missing


def no_place(name: str, kind: str) -> NotInFormat:
    """Return the error for a part that no format has."""
    article = "an" if kind[0] in "aeiouAEIOU" else "a"
    return NotInFormat(Gap(f"nothing for {article} {kind}", (name,)))


def refusal(model: str, parts: Sequence[Gap], ignore: Sequence[str]) -> ModelError:
    """Return the error for all parts that a format does not have, with the whole list of names to ignore."""
    names = list(dict.fromkeys(name for gap in parts for name in gap.names))
    kinds = dict[str, dict[str, None]]()
    for gap in parts:
        kinds.setdefault(gap.what, {}).update(dict.fromkeys(gap.names))
    whole = len(names) > 1
    text = "; ".join(f"{what} ({listed([*some])})" if whole else what for what, some in kinds.items())
    these, them = ("these parts", "them") if whole else ("it", "it")
    other = ", or export it as .xml" if all(what.startswith("no ") for what in kinds) else ""
    message = (
        f"the format has {text}. Remove {these}, or leave {them} out with ignore={[*ignore, *names]}{other}."
    )
    return ModelError(message, part=f"model {quote(model)}" if whole else names[0])
