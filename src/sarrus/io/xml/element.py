"""XML elements with line numbers, built from expat's events.

No document type is accepted, so no entity can be declared, and nothing outside the file is ever read.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from ...model.errors import ModelError
from ...model.file.text.document import DEEPEST
from ...model.file.text.source import MOST, read_bytes
from ...model.show import counted, quote


@dataclass(frozen=True, eq=False)
class Element:
    """An element with its attributes, its children in order, its text, its line and its file."""

    tag: str
    attributes: dict[str, str]
    line: int
    children: list[Element] = field(default_factory=list, repr=False)
    pieces: list[str] = field(default_factory=list, repr=False)  # of the text
    file: str = ""

    def all(self, tag: str) -> Iterator[Element]:
        """Yield the children with a tag."""
        return (child for child in self.children if child.tag == tag)

    @property
    def text(self) -> str:
        """The text in the element, without spaces around it."""
        return "".join(self.pieces).strip()


def read_xml(path: Path) -> Element:
    """Return the root element of an XML file.

    Raises
    ------
    ModelError
        If it cannot be read, is not well-formed, has a document type, or nests too deep.
    """
    content = read_bytes(path)
    if not content.strip():
        raise ModelError("is empty. Give a robot with at least one link.", part="file", where=str(path))
    return _Reader(str(path)).root(content)


class _Reader:
    def __init__(self, file: str) -> None:
        self.file = file
        self.open: list[Element] = []
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._text
        self.parser.StartDoctypeDeclHandler = self._doctype
        self.done: Element | None = None
        self.count = 0

    def root(self, content: bytes) -> Element:
        try:
            self.parser.Parse(content, True)
        except expat.ExpatError as error:
            raise self._refusal(f"is not well-formed XML, {_reason(error)}. Fix it.", error.lineno) from None
        except ModelError:
            raise
        except (LookupError, ValueError) as error:
            raise self._refusal(f"cannot be decoded, {error}. Save it as UTF-8.", 1) from None
        assert self.done is not None
        return self.done

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        line = self.parser.CurrentLineNumber
        element = Element(tag, attributes, line, file=self.file)
        if tag.startswith("xacro:"):
            message = f"has the macro <{tag}>. Expand it first, xacro robot.urdf.xacro > robot.urdf."
            raise self._refusal(message, line)
        self.count += 1
        if self.count > MOST:
            raise self._refusal(f"has more than {MOST:,} elements. Split it, or build it in Python.", line)
        if len(self.open) == DEEPEST:
            message = f"is nested deeper than {DEEPEST} levels at {quote(tag)}. Remove levels."
            raise self._refusal(message, line)
        if self.open:
            self.open[-1].children.append(element)
        self.open.append(element)

    def _end(self, tag: str) -> None:
        self.done = self.open.pop()

    def _text(self, piece: str) -> None:
        self.open[-1].pieces.append(piece)

    def _doctype(self, *declared: object) -> None:
        message = "declares a document type, which could define entities. Remove the line with <!DOCTYPE."
        raise self._refusal(message, self.parser.CurrentLineNumber)

    def _refusal(self, message: str, line: int) -> ModelError:
        return ModelError(message, part="file", where=f"{self.file}:{line}")


def _reason(error: expat.ExpatError) -> str:
    return expat.ErrorString(error.code).lower()


def left_out(roots: Iterable[Element], used: Mapping[str, str], noted: Mapping[str, str]) -> list[str]:
    """Return one message for each kind of thing that is in the file and not in the model.

    Parameters
    ----------
    roots : of the file, or elements of it whose tags begin the paths
    used : path of an element, ``"robot/link/inertial"``, to the attributes that are used
    noted
        Path of an element that is not used, or used in part, to the message on ``{n}`` of them, for `counted`. A path
        that ends in ``/*`` is that of all elements in another one which are not used.
    """
    counts = Counter(one for root in roots for one in _found(root, root.tag, used, noted))
    return [counted(message, n) for message, n in counts.items()]


def _found(element: Element, path: str, used: Mapping[str, str], noted: Mapping[str, str]) -> Iterator[str]:
    unknown = f"{{n}} element[s] <{element.tag}> [is|are] left out: [its|their] meaning is not known"
    if path in noted:
        yield noted[path]
    elif path not in used:
        yield noted.get(f"{path.rpartition('/')[0]}/*", unknown)
    if path not in used:
        return
    for name in element.attributes:
        if name not in used[path].split() and not name.startswith("xmlns"):
            where = f"of {{n}} element[s] <{element.tag}>"
            yield f"the attribute {name} {where} is left out: its meaning is not known"
    for child in element.children:
        yield from _found(child, f"{path}/{child.tag}", used, noted)
