"""The named parts of a <robot>: its links, its joints."""

from __future__ import annotations

from typing import NamedTuple

from ...model.show import quote
from .element import Element
from .reader import Reader


class Part(NamedTuple):
    """A link or joint, and the reader that names it in errors."""

    element: Element
    reader: Reader


def named(root: Element, tag: str, reader: Reader) -> dict[str, Part]:
    """Return the children with a tag by their names, which must be different."""
    found: dict[str, Part] = {}
    for element in root.all(tag):
        name = Reader(reader.file, tag).text(element, "name")
        if name in found:
            first = found[name].element.line
            message = f"the {tag} {quote(name)} is there twice, the first time on line {first}"
            raise reader.refusal(f"{message}; rename one of them", element.line)
        found[name] = Part(element, Reader(reader.file, f"{tag} {quote(name)}"))
    return found
