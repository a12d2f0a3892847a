"""Arguments of a wrong kind, refused with the right call."""

from __future__ import annotations

from ..model.announcement import carry
from ..system import System


def refuse_other_system(given: object, analysis: str) -> None:
    """Refuse what is no system; the result of the analysis carries the warnings of one.

    Raises
    ------
    TypeError
        With the right call.
    """
    if isinstance(given, System):
        return carry(given.warnings)
    call = f"sr.{analysis}(sr.System(model), ...)"
    if isinstance(given, str):
        call = f'sr.{analysis}(sr.System(sr.load("{given}")), ...)'
    raise TypeError(f"{analysis} needs a System, got {kind(given)}. Call {call}.")


def kind(given: object) -> str:
    """What something is, in words."""
    name = type(given).__name__
    return "nothing" if given is None else f"{'an' if name[0] in 'AEIOU' else 'a'} {name}"
