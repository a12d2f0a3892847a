"""Resolution of names in an included file: its own names first, then those of the including file."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass
class Scope:
    """The names that a file defines, as it calls them, and the prefix that it was included with."""

    prefix: str = ""
    outer: Scope | None = None
    names: set[str] = field(default_factory=set)

    def full(self, path: str) -> str:
        """Return the name that ``path`` has in the whole model."""
        if path.partition(".")[0] in self.names:
            return self.prefix + path
        return self.outer.full(path) if self.outer else path


class Text(str):
    """A text of a file that was included with a prefix."""

    scope: Scope


def full_name(text: Any, path: str) -> str:
    """Return the name that ``path``, found in ``text``, has in the whole model."""
    return text.scope.full(path) if isinstance(text, Text) else path


def scoped(data: Any, scope: Scope) -> Any:
    """Return plain data with its texts bound to a scope; without a prefix it is the same."""
    if not scope.prefix:
        return data
    if isinstance(data, str):
        text = Text(data)
        text.scope = scope
        return text
    if isinstance(data, dict):
        return {key: scoped(value, scope) for key, value in data.items()}
    return [scoped(value, scope) for value in data] if isinstance(data, list) else data
