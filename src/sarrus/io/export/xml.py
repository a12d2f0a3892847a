"""XML elements and numbers of exported files."""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from ...model.quantity import Array


def text_of(element: Element) -> str:
    """Return an element as the text of a file."""
    indent(element)
    return f'<?xml version="1.0"?>\n{tostring(element, encoding="unicode")}\n'


def numbers(values: Iterable[float] | Array) -> str:
    """Return numbers with all of their digits."""
    return " ".join(repr(float(value) + 0.0) for value in values)


def child(parent: Element, tag: str, text: str = "", **attributes: object) -> Element:
    """Return a new child with attributes; numbers have all digits, and None is left out."""
    given = {name.rstrip("_"): _word(value) for name, value in attributes.items() if value is not None}
    element = SubElement(parent, tag, given)
    element.text = text or None
    return element


def _word(value: object) -> str:
    if isinstance(value, str):
        return value
    return numbers(value) if isinstance(value, Iterable) else repr(float(value))  # type: ignore[arg-type]
