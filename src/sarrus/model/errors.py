"""Errors and warnings: one message each, with the part, the file and line, and the remedy."""

from __future__ import annotations


class SarrusError(Exception):
    """Base of every error that this library raises on purpose."""


class ModelError(SarrusError, ValueError):
    """A model that cannot be meant, said in one sentence.

    Parameters
    ----------
    sentence
        What is wrong, and what to do instead.
    part
        The part it is about, for example ``body "rod"``.
    field
        The name of the wrong entry of that part, for example ``mass``.
    where
        File and line, ``model.yaml:6``, when the model came from a file.
    more
        How many further errors were found beside this one.
    """

    def __init__(
        self, sentence: str, *, part: str = "", field: str = "", where: str = "", more: int = 0
    ) -> None:
        super().__init__(sentence)
        self.sentence = sentence
        self.part = part
        self.field = field
        self.where = where
        self.more = more

    def __str__(self) -> str:
        told = ": ".join(text for text in (self.where, self.part, self.sentence) if text)
        return f"{told} (and {self.more} more)" if self.more else told


class SarrusWarning(UserWarning):
    """A result that may not mean what the user expects; its ``warnings`` hold the same messages."""


class StrictError(SarrusError, RuntimeError):
    """A warning of an analysis that was called with ``strict=True``."""
