"""Elements and attributes of an XML file that an import does not use: one note for each kind."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping

from ..plurals import counted
from .element import Element


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
