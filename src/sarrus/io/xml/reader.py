"""The named parts of an XML file, and their attributes as numbers, vectors and poses; errors name the line."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Sequence
from contextlib import AbstractContextManager
from difflib import get_close_matches
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from ...model.errors import ModelError, restated
from ...model.geometry.motion import pose
from ...model.geometry.orientation import EulerAngles, euler_parameters
from ...model.quantity import Array, direction, number
from ...model.show import quote, suggest
from .element import Element

if TYPE_CHECKING:
    from ...model.geometry.pose import Pose

Look = TypeVar("Look")
FLAGS = {"true": True, "1": True, "false": False, "0": False}


class Reader:
    """Reads the elements of one named part, as ``joint "elbow"``, of a file."""

    def __init__(self, file: str, part: str) -> None:
        self.file, self.part = file, part

    def refusal(self, message: str, line: int) -> ModelError:
        """Return the error for something on a line."""
        return ModelError(message, part=self.part, where=f"{self.file}:{line}")

    def placed(self, line: int) -> AbstractContextManager[None]:
        """Add the part and the line to a ModelError raised inside."""
        return restated(part=self.part, where=f"{self.file}:{line}")

    def check(self, element: Element, attributes: Sequence[str], children: Sequence[str] = ()) -> None:
        """Refuse what looks like a misspelt attribute or child; `left_out` notes what is really unknown."""
        for attribute in element.attributes:
            self._spelling(f"<{element.tag}> has no attribute", attribute, attributes, element.line)
        for child in element.children:
            self._spelling(f"<{element.tag}> has no element", child.tag, children, child.line)

    def one(self, element: Element, tag: str) -> Element | None:
        """Return the only child with a tag, or None."""
        children = list(element.all(tag))
        if len(children) > 1:
            message = f"has <{tag}> twice, the first time on line {children[0].line}. Remove one of them."
            raise self.refusal(message, children[1].line)
        return children[0] if children else None

    def needed(self, element: Element, tag: str, example: str) -> Element:
        """Return the only child with a tag; it must be there."""
        child = self.one(element, tag)
        if child is None:
            raise self.refusal(f"<{element.tag}> has no <{tag}>. Add it, as in {example}.", element.line)
        return child

    def text(self, element: Element, attribute: str) -> str:
        """Return an attribute that must be there and not be empty."""
        value = element.attributes.get(attribute, "").strip()
        if not value:
            message = f'<{element.tag}> has no {attribute}. Add it, as in {attribute}="...".'
            raise self.refusal(message, element.line)
        return value

    def number(self, element: Element, attribute: str, default: float | None = None) -> float:
        """Return an attribute as a finite number."""
        if default is not None and attribute not in element.attributes:
            return default
        label = f"<{element.tag}> {attribute}"
        return self._numbers(element.line, label, self.text(element, attribute), 1)[0]

    def content(self, element: Element, count: int = 1) -> list[float]:
        """Return the text of an element as finite numbers."""
        return self._numbers(element.line, f"<{element.tag}>", element.text, count)

    def flag(self, element: Element) -> bool:
        """Return the text of an element, or in old files its value, as true or false."""
        text = element.text or element.attributes.get("value", "")
        if text.lower() not in FLAGS:
            message = f"<{element.tag}> must be true or false, but is {quote(text)}. Correct it."
            raise self.refusal(message, element.line)
        return FLAGS[text.lower()]

    def maybe(self, element: Element, attribute: str) -> float | None:
        """Return an attribute as a finite number, or None if it is not there."""
        return self.number(element, attribute) if attribute in element.attributes else None

    def vector(self, element: Element | None, attribute: str, default: Sequence[float]) -> Array:
        """Return an attribute as finite numbers, as many as the default has."""
        if element is None or attribute not in element.attributes:
            return np.array(default, dtype=float)
        label = f"<{element.tag}> {attribute}"
        return np.array(self._numbers(element.line, label, self.text(element, attribute), len(default)))

    def pose(self, element: Element) -> Pose:
        """Return the pose that the child <origin> gives: xyz [m], and rpy [rad] about fixed x, y, z in turn."""
        origin = self.one(element, "origin")
        if origin is not None:
            self.check(origin, ("xyz", "rpy"))
        roll, pitch, yaw = self.vector(origin, "rpy", (0.0, 0.0, 0.0))
        turn = EulerAngles((yaw, pitch, roll), "zyx")
        return pose(self.vector(origin, "xyz", (0.0, 0.0, 0.0)), euler_parameters(turn))

    def direction(self, element: Element | None, default: Sequence[float]) -> Array:
        """Return the unit vector of the attribute xyz."""
        vector = self.vector(element, "xyz", default)
        if element is None:
            return vector
        self.check(element, ("xyz",))
        with self.placed(element.line):
            return direction(vector, f"<{element.tag}> xyz")

    def _numbers(self, line: int, label: str, text: str, count: int) -> list[float]:
        words = text.split()
        if len(words) != count:
            wanted = "1 number" if count == 1 else f"{count} numbers with spaces between"
            message = f"{label} must be {wanted}, but is {quote(text)}. Correct it."
            raise self.refusal(message, line)
        return [self._number(word, label, line) for word in words]

    def _number(self, word: str, label: str, line: int) -> float:
        try:
            value = float(word) if "_" not in word else float("_")
        except ValueError:
            message = f"{label} must be a number, but is {quote(word)}. Write it as in 1.5e-3."
            raise self.refusal(message, line) from None
        with self.placed(line):
            return number(value, label)

    def _spelling(self, message: str, word: str, known: Sequence[str], line: int) -> None:
        if word not in known and get_close_matches(word, known, n=1, cutoff=0.75):
            raise self.refusal(f"{message} {quote(word)}. {suggest(word, known)}", line)


def read_shapes(
    element: Element,
    reader: Reader,
    kinds: Container[str],
    read: Callable[[Element, Element], Look],
    notes: list[str],
) -> Iterator[Look]:
    """Yield what a link looks like; unknown shapes are left out, and wrong ones with a note.

    Parameters
    ----------
    element, reader : the link
    kinds : tags of shapes
    read : the function of a <visual> and the shape in it
    notes : to which those on wrong shapes are added
    """
    for visual in element.all("visual"):
        for shape in (s for geometry in visual.all("geometry") for s in geometry.children if s.tag in kinds):
            try:
                yield read(visual, shape)
            except ModelError as error:
                notes.append(f"a visual of {reader.part} is left out, line {shape.line}: {error.message}")


class Part(NamedTuple):
    """A link or joint, and the reader that names it in errors."""

    element: Element
    reader: Reader


def named(root: Element, tag: str, reader: Reader) -> dict[str, Part]:
    """Return the children with a tag by their names, which must be different."""
    parts: dict[str, Part] = {}
    for element in root.all(tag):
        name = Reader(reader.file, tag).text(element, "name")
        if name in parts:
            first = parts[name].element.line
            message = f"the {tag} {quote(name)} is there twice, the first time on line {first}"
            raise reader.refusal(f"{message}. Rename one of them.", element.line)
        parts[name] = Part(element, Reader(reader.file, f"{tag} {quote(name)}"))
    return parts
