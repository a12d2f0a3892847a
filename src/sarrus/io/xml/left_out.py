"""Elements and attributes of an XML file that an import does not use: one note for each kind."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping

from .element import Element


def left_out(root: Element, used: Mapping[str, str], noted: Mapping[str, str]) -> list[str]:
    """Return one message for each kind of thing that is in the file and not in the model.

    Parameters
    ----------
    root : of the file
    used : path of an element, ``"robot/link/inertial"``, to the attributes that are used
    noted : path of an element that is not used, or used in part, to the message about ``{n}`` of them
    """
    counts = Counter(_found(root, root.tag, used, noted))
    return [message.format(n=n) for message, n in counts.items()]


def _found(element: Element, path: str, used: Mapping[str, str], noted: Mapping[str, str]) -> Iterator[str]:
    if path in noted:
        yield noted[path]
    if path not in used:
        if path not in noted:
            yield f"{{n}} elements <{_plain(element.tag)}> are left out: their meaning is not known"
        return
    for name in element.attributes:
        if name not in used[path].split() and not name.startswith("xmlns"):
            word, tag = _plain(name), _plain(element.tag)
            yield f"the attribute {word} of {{n}} elements <{tag}> is left out: its meaning is not known"
    for child in element.children:
        yield from _found(child, f"{path}/{child.tag}", used, noted)


def _plain(word: str) -> str:
    """Return a word of the file as it can be in a format string."""
    return word.replace("{", "{{").replace("}", "}}")
