"""Errors and warnings: one message each, with the part, the file and line, and the remedy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from .deprecated import with_former_names

SHOWN = 4  # names in a message


class SarrusError(Exception):
    """Base class of all errors that Sarrus raises."""


@with_former_names
class ModelError(SarrusError, ValueError):
    """An invalid model, described by one message.

    Parameters
    ----------
    message
        What is wrong, and what to do.
    part
        The part that the message is about, for example ``body "rod"``.
    field
        The name of the wrong field of that part, for example ``mass``.
    where
        File and line, ``model.yaml:6``, if the model is from a file.
    more
        The number of further errors.
    """

    def __init__(
        self, message: str, *, part: str = "", field: str = "", where: str = "", more: int = 0
    ) -> None:
        super().__init__(message)
        self.message = message
        self.part = part
        self.field = field
        self.where = where
        self.more = more

    def __str__(self) -> str:
        text = ": ".join(piece for piece in (self.where, self.part, self.message) if piece)
        return f"{text} (and {self.more} more)" if self.more else text


@contextmanager
def restated(prefix: str = "", *, part: str = "", field: str = "", where: str = "") -> Iterator[None]:
    """Raise a ModelError of the block anew, with a prefix of its message, a part if it names none, a field, a place.

    Raises
    ------
    ModelError
    """
    try:
        yield
    except ModelError as error:
        message = f"{prefix} {error.message}" if prefix else error.message
        raise ModelError(
            message, part=error.part or part, field=field or error.field, where=where or error.where
        ) from None


class SarrusWarning(UserWarning):
    """Warning about a result that may be unintended; the result lists the same messages in ``warnings``."""


class StrictError(SarrusError, RuntimeError):
    """A warning in a block `strict`."""


def listed(names: Sequence[str], separator: str = ", ", most: int = SHOWN) -> str:
    """At most `most` names for a message, with a separator between them, and how many more there are."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return separator.join(names[:most]) + more
