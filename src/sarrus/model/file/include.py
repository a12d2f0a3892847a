"""A model file with the files that it includes, as one document."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path as FilePath
from typing import Annotated, Any

from pydantic import AfterValidator, Field, StrictStr, ValidationError, create_model

from ..bodies.shape import REMEDY, VARIABLE, inside, listed
from ..checks.findings import KINDS, Origin, Path, part_name
from ..checks.names import NAME, matches
from ..expansion.mappings import RATES
from ..mirror_image import SIDES
from ..show import quote, suggest
from .hardpoints import SECTION as HARDPOINTS
from .scope import Scope, full_name, scoped
from .sides import SECTIONS as PARTS
from .stated import Entry, invalid, list_of, one_of
from .text.document import Document, refusal
from .text.source import MOST as MOST_OF_FILE
from .text.source import SHIPPED

AXES = ("x", "y", "z")
WORD = re.compile(r"[A-Za-z_][\w.]*")  # a name in a formula, which may have dots
SECTIONS = (*KINDS, RATES)  # all else, such as gravity, counts only in the file that is loaded
DEEPEST = 16  # files within files
MOST = 500  # files of one model


def _prefix(text: str) -> str:
    if text and not matches(NAME, text):
        raise invalid(
            f"must be letters, digits and _, starting with a letter, but is {quote(text)}. Change it."
        )
    return text


class IncludeEntry(Entry):
    """A file whose parts become parts of this model."""

    file: Annotated[StrictStr, Field(description="Relative to the folder of this file.")]
    prefix: Annotated[StrictStr, AfterValidator(_prefix)] = ""
    parameters: dict[str, Any] = Field(
        default={},
        description="New values of parameters of that file, and of coordinates of its hardpoints [m].",
    )
    without: list[StrictStr] = Field(default=[], description="Parts of that file to leave out, by name.")


def _form(value: Any) -> str:
    return "mapping" if isinstance(value, (dict, IncludeEntry)) else "file"


IncludeForm: Any = one_of(_form, file=StrictStr, mapping=IncludeEntry)


Includes: Any = create_model("Includes", include=(list_of(IncludeForm), ...))


def with_included(document: Document) -> Document:
    """Return a document with the parts of all files that it includes, under their prefixes.

    Raises
    ------
    ModelError
        If a file cannot be read, includes itself, or has a name that is taken.
    """
    if not (isinstance(document.data, dict) and "include" in document.data):
        return document
    return _Gatherer().gather(_checked(document), (FilePath(document.origin.file).resolve(),), Scope())


class _Gatherer:
    """Walks through the files and counts them."""

    def __init__(self) -> None:
        self.count = 0
        self.entries = 0

    def gather(self, document: Document, chain: tuple[FilePath, ...], scope: Scope) -> Document:
        """Return the document with its own parts and those of its files, all under their full names."""
        whole = _renamed(document, scope)
        entries = _entries(document)
        for place, entry in enumerate(entries):
            part = self._part(document, ("include", place), entry, chain, scope)
            _join(whole, part, document, ("include", place))
            whole = whole._replace(mirrored=whole.mirrored | part.mirrored)
        return whole

    def _part(
        self, document: Document, at: Path, entry: IncludeEntry, chain: tuple[FilePath, ...], scope: Scope
    ) -> Document:
        from .hardpoints import with_unit
        from .load import read
        from .sides import with_sides

        path = chain[-1].parent / entry.file
        self._check(document, at, path, chain)
        inner = Scope(scope.prefix + entry.prefix, scope)
        read_one = with_sides(with_unit(read(FilePath(document.origin.file).parent / entry.file)))
        self.entries += len(read_one.origin.lines)
        if self.entries > MOST_OF_FILE:
            message = f"includes more than {MOST_OF_FILE:,} entries. Build such a model in Python."
            raise _wrong(document, at, message)
        part = self.gather(_checked(read_one), (*chain, path.resolve()), inner)
        scope.names |= {entry.prefix + name for name in inner.names}
        _override(part, entry.parameters, inner, document, at, scope)
        return _without(part, entry.without, inner.prefix, document, at)

    def _check(self, document: Document, at: Path, path: FilePath, chain: tuple[FilePath, ...]) -> None:
        self.count += 1
        folders = [place.resolve() for place in (chain[0].parent, SHIPPED, *listed(VARIABLE))]
        there = os.path.isfile(path)  # false, not an error, for names that no file can have
        if not inside(path, folders) or (there and not inside(path.resolve(), folders)):
            message = f"includes {quote(path.name)}, which is outside of the folder of the model. {REMEDY}"
            raise _wrong(document, at, message)
        if not there:
            raise _wrong(document, at, f"includes {quote(path.name)}, which is no file. Check the path.")
        if path.resolve() in chain:
            names = " includes ".join(file.name for file in (*chain[chain.index(path.resolve()) :], path))
            raise _wrong(document, at, f"includes itself, {names}. Remove one of the includes.")
        if len(chain) >= DEEPEST or self.count > MOST:
            raise _wrong(
                document, at, f"includes more than {MOST} files or {DEEPEST} levels. Join some of them."
            )


def _entries(document: Document) -> list[IncludeEntry]:
    from .validation_messages import first_error

    data = document.data
    try:
        found = Includes.model_validate({"include": data.get("include", [])}).include
    except ValidationError as error:
        raise first_error(error, document) from None
    return [entry if isinstance(entry, IncludeEntry) else IncludeEntry(file=entry) for entry in found]


def _checked(document: Document) -> Document:
    """Return a document, or refuse what the layout of the whole model will not see."""
    from .layout import layout

    file = document.origin.file
    if not isinstance(document.data, dict):
        raise refusal("must be a mapping. Give keys and values, as in key: value.", file, 1)
    known = [field.alias or name for name, field in layout(document.data).model_fields.items()]
    for key, value in document.data.items():
        if key not in known:
            raise _wrong(document, (key,), f"has no key {quote(key)}. {suggest(key, known)}")
        if key in SECTIONS and not isinstance(value, dict):
            raise _wrong(
                document, (key,), f"{key} must be a mapping. Give keys and values, as in key: value."
            )
    return document


def _renamed(document: Document, scope: Scope) -> Document:
    """Return the sections of a file with prefixed names, and the file of each part."""
    data, origin = document.data, document.origin
    scope.names |= {name for section in KINDS for name in _section(data, section)}
    sections = {
        section: {
            scope.prefix + name: scoped(value, scope) for name, value in _section(data, section).items()
        }
        for section in SECTIONS
        if section in data
    }
    alone = {key: value for key, value in data.items() if key != "include"}
    lines = {_under(path, scope.prefix): line for path, line in origin.lines.items()}
    files = {path[:2]: origin.file for path in lines if path and path[0] in SECTIONS}
    mirrored = frozenset(scope.prefix + name for name in document.mirrored)
    return Document({**alone, **sections}, Origin(origin.file, lines, files), mirrored)


def _section(data: dict[str, Any], section: str) -> dict[str, Any]:
    found = data.get(section)
    return found if isinstance(found, dict) else {}


def _under(path: Path, prefix: str) -> Path:
    if len(path) < 2 or path[0] not in SECTIONS:
        return path
    return (path[0], f"{prefix}{path[1]}", *path[2:])


def _join(whole: Document, part: Document, document: Document, at: Path) -> None:
    """Add the parts of an included file to the whole."""
    for section in SECTIONS:
        for name, value in _section(part.data, section).items():
            if name in _section(whole.data, section):
                named = f"rate of {quote(name)}" if section == RATES else part_name((section, name))
                message = f"brings a second {named}. Give it a prefix, or remove one of them."
                raise _wrong(document, at, message)
            whole.data.setdefault(section, {})[name] = value
    lines = {path: line for path, line in part.origin.lines.items() if len(path) > 1 and path[0] in SECTIONS}
    whole.origin.lines.update(lines)
    whole.origin.files.update(part.origin.files)
    whole.origin.given.update(part.origin.given)


def _override(
    part: Document, given: dict[str, Any], inner: Scope, document: Document, at: Path, scope: Scope
) -> None:
    """Replace parameters and coordinates of hardpoints of an included file by the values that the include gives."""
    own, points = _section(part.data, "parameters"), _section(part.data, HARDPOINTS)
    changed: dict[str, str] = {}
    for place, value in _leaves(given):
        name = ".".join(place)
        path = f"{inner.prefix}{place[0]}", *place[1:]
        entry = (*at, "parameters", *(place if place[0] in given else (name,)))
        changed[".".join(path)] = document.origin.where(entry)
        if path[0] in points:
            for axis in _move(points[path[0]], place, value, scope, document, at):
                _set_place(part.origin, (HARDPOINTS, path[0], axis), document, entry)
            continue
        holder = own.get(path[0]) if path[1:] else own
        if not isinstance(holder, dict) or isinstance(holder.get(path[-1], {}), dict):
            known = _names({**points, **own}, inner.prefix)
            message = f"gives the unknown parameter {quote(name)}. {suggest(name, known)}"
            raise _wrong(document, (*at, "parameters", name), message)
        holder[path[-1]] = scoped(value, scope)
        _set_place(part.origin, ("parameters", *path), document, entry)
    _note_users(part, changed)


def _set_place(origin: Origin, path: Path, document: Document, entry: Path) -> None:
    """Note that the value at a path is from an entry of the including document."""
    origin.lines[path], origin.files[path] = document.origin.line(entry), document.origin.file


def _note_users(part: Document, changed: dict[str, str]) -> None:
    """Note the places of changed values, by name, for the entries whose formulas use them, also by other parameters."""
    texts = _texts({section: _section(part.data, section) for section in SECTIONS})
    names = {path: {full_name(text, word) for word in WORD.findall(text)} for path, text in texts}
    given = part.origin.given
    while changed:
        users = {
            path: changed[name]
            for path, words in names.items()
            for name in words & changed.keys()
            if path not in given
        }
        given.update(users)
        changed = {".".join(map(str, path[1:])): where for path, where in users.items()}


def _texts(data: Any, path: Path = ()) -> Iterator[tuple[Path, str]]:
    """Yield the texts in plain data, with their paths."""
    if isinstance(data, str):
        yield path, data
    elif isinstance(data, dict | list):
        for key, value in data.items() if isinstance(data, dict) else enumerate(data):
            yield from _texts(value, (*path, key))


def _move(
    point: Any, place: tuple[str, ...], value: Any, scope: Scope, document: Document, at: Path
) -> Iterator[int]:
    """Replace one coordinate of a hardpoint, ``ball.z``, or all three, ``ball: [x, y, z]``; yield their indices."""
    axes = place[1:] if len(place) > 1 else AXES
    values = [value] if len(place) > 1 else value
    if not (isinstance(point, list) and len(point) == len(AXES)):
        return  # it is refused where the hardpoints are read
    if not set(axes) <= set(AXES) or not isinstance(values, list) or len(values) != len(axes):
        name = ".".join(place)
        message = f"gives {quote(name)}, which is no coordinate of a hardpoint. Give {place[0]}.x, .y or .z,"
        entry = place[0] if len(place) == 1 else name
        raise _wrong(document, (*at, "parameters", entry), f"{message} or all three in a list.")
    for axis, one in zip(axes, values, strict=True):
        point[AXES.index(axis)] = scoped(one, scope)
        yield AXES.index(axis)


def _without(part: Document, names: list[str], prefix: str, document: Document, at: Path) -> Document:
    """Return an included file without some of its parts; a name of a side is that of the parts of both sides."""
    data, sides = dict(part.data), [f"{prefix}{name}" for name in names]
    for name in sides:
        own = {name, *(f"{name}_{side}" for side in SIDES if f"{name}_{side}" in part.mirrored)}
        found = [section for section in PARTS if own & _section(data, section).keys()]
        if not found:
            known = [one.removeprefix(prefix) for section in PARTS for one in _section(data, section)]
            message = f"leaves out {quote(name.removeprefix(prefix))}, which that file does not have"
            raise _wrong(
                document, (*at, "without"), f"{message}. {suggest(name.removeprefix(prefix), known)}"
            )
        for section in found:
            data[section] = {key: entry for key, entry in _section(data, section).items() if key not in own}
    left = {name for section in PARTS for name in _section(data, section)}
    return Document(data, part.origin, frozenset(part.mirrored & left))


def _leaves(given: dict[str, Any]) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield names and values; ``crank: {length: 3}`` and ``crank.length: 3`` are the same."""
    for name, value in given.items():
        group = value.items() if isinstance(value, dict) else ()
        yield from (
            (((name, one), number) for one, number in group) if group else [((*name.split("."),), value)]
        )


def _names(own: dict[str, Any], prefix: str) -> list[str]:
    return [".".join(place).removeprefix(prefix) for place, _ in _leaves(own)]


def _wrong(document: Document, path: Path, message: str) -> Exception:
    return refusal(message, document.origin.file, document.origin.line(path))
