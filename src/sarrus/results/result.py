"""Base class of results: warnings, which are printed with each result."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, eq=False)
class Result:
    """Base of the results of analyses.

    Attributes
    ----------
    warnings : short messages about what may not be as the user expects; Python has issued them, too
    """

    warnings: tuple[str, ...] = field(default=(), kw_only=True, repr=False)

    def summary(self) -> str:
        """The result in words, without its warnings."""
        return repr(self)

    def __str__(self) -> str:
        return "\n".join([self.summary(), *(f"warning: {message}" for message in self.warnings)])
