"""The reference of all public names, generated from docstrings when the documentation is built."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
CHAPTERS = {
    "model": ("models", "Models: bodies, joints, drivers, forces"),
    "system": ("systems", "Systems: the equations and their derivatives"),
    "outputs": ("outputs", "Outputs"),
    "analyses": ("analyses", "Analyses"),
    "studies": ("studies", "Studies"),
    "results": ("results", "Results"),
    "views": ("views", "Pictures"),
    "io": ("import", "Import"),
}
INNER = {
    "primitives",
    "coordinates",
    "relations",
    "frames",
    "friction",
    "resolve",
}  # methods that compose parts from elements
SECTION = re.compile(r"^(\w[\w ]*)\n-{3,}\n", re.MULTILINE)


def write(app: Any = None) -> None:
    """Write one page for each part of the package."""
    import sarrus

    folder = HERE / "api"
    folder.mkdir(exist_ok=True)
    names = [name for name in sarrus.__all__ if not name.startswith("__")]
    homes = {name: _home(getattr(sarrus, name)) for name in names}
    for home, (page, title) in CHAPTERS.items():
        own = sorted((name for name in names if homes[name] == home), key=str.lower)
        entries = (line for name in own for line in _entry(name, getattr(sarrus, name)))
        table = _declared() if home == "outputs" else ()
        _update(folder / f"{page}.md", "\n".join([f"# {title}", "", *table, *entries]))
    lost = [name for name in names if homes[name] not in CHAPTERS]
    if lost:
        raise RuntimeError(f"these public names have no chapter in {__file__}: {', '.join(lost)}")


def _declared() -> Iterator[str]:
    """A table of what forces declare as outputs, with the beginning of its description."""
    import sarrus
    from sarrus.elements import BUILT_IN

    kinds = {kind.__name__: kind for kind in BUILT_IN if kind.outputs and hasattr(sarrus, kind.__name__)}
    common = ("force_on_last_body", "torque_on_last_body")
    yield from ("## Outputs of forces", "", "| force | output | unit | meaning |", "|---|---|---|---|")
    rows = [("every force", kinds["Bushing"], one) for one in kinds["Bushing"].outputs.values()]
    rows += [
        (f"`{name}`", kind, one)
        for name, kind in sorted(kinds.items())
        for one in kind.outputs.values()
        if one.method not in common
    ]
    for name, kind, one in rows:
        words = ", ".join(f"`.{one.word}.{axis}`" for axis in one.axes) or f"`.{one.word}`"
        meaning = (inspect.getdoc(getattr(kind, one.method)) or "").split("\n\n")[0].replace("|", "\\|")
        yield f"| {name} | {words} | {one.unit} | {meaning} |"
    yield ""


def _home(what: Any) -> str:
    """The part of the package that defines an object; objects without a module, like the ground, are of the model."""
    module = str(getattr(what, "__module__", ""))
    return module.split(".")[1] if module.startswith("sarrus.") else "model"


def _update(path: Path, text: str) -> None:
    """Write a page only if it has changed, so that Sphinx does not read it again."""
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def _entry(name: str, what: Any) -> Iterator[str]:
    yield f"## {name}\n"
    if not (inspect.isclass(what) or inspect.isfunction(what)):
        yield f"`sarrus.{name}`: {_plain(type(what).__doc__ or '')}\n"
        return
    yield f"```python\nsarrus.{name}{_signature(what)}\n```\n"
    yield from _markdown(inspect.getdoc(what) or "")
    if inspect.isclass(what):
        for own, member in _members(what):
            arguments = "" if isinstance(member, property) else _signature(member)
            yield f"### {name}.{own}\n"
            yield f"```python\n{name}.{own}{arguments}\n```\n"
            yield from _markdown(inspect.getdoc(member) or "")


def _signature(what: Any) -> str:
    try:
        found = inspect.signature(what)
    except (TypeError, ValueError):
        return "(...)"
    shown = [
        p.replace(annotation=inspect.Parameter.empty) for p in found.parameters.values() if p.name != "self"
    ]
    text = _clean(str(inspect.Signature(shown)))
    if len(text) < 90:
        return text
    lines = [_clean(str(p)) for p in shown]
    named = next((n for n, p in enumerate(shown) if p.kind is inspect.Parameter.KEYWORD_ONLY), None)
    if named is not None and not any(p.kind is inspect.Parameter.VAR_POSITIONAL for p in shown):
        lines.insert(named, "*")
    return "(\n    " + ",\n    ".join(lines) + ",\n)"


def _clean(text: str) -> str:
    """Remove memory addresses of default values."""
    return re.sub(r"<[^<>]*>", "...", text)


def _members(what: type) -> Iterator[tuple[str, Any]]:
    """Public methods and properties with a docstring, including those of base classes, except the ones in INNER."""
    seen: set[str] = set()
    for base in what.__mro__:
        if base.__module__.startswith("sarrus."):
            for name, member in vars(base).items():
                plain = getattr(member, "__func__", member)
                good = inspect.isfunction(plain) or isinstance(plain, property)
                known = name.startswith("_") or name in seen or (name in INNER and _home(what) == "model")
                if good and not known and plain.__doc__:
                    seen.add(name)
                    yield name, plain


def _markdown(doc: str) -> Iterator[str]:
    """A numpydoc docstring as Markdown: paragraphs, and a list for each section."""
    pieces = SECTION.split(doc)
    yield _plain(pieces[0]) + "\n"
    for title, body in zip(pieces[1::2], pieces[2::2], strict=True):
        yield f"**{title}**\n"
        yield from _list(body) if title not in ("Notes", "Examples") else [_plain(body) + "\n"]


def _list(body: str) -> Iterator[str]:
    """Items ``name : description``, or ``name`` with indented lines below it."""
    entries: list[list[str]] = []
    for line in body.splitlines():
        if line.strip():
            if line.startswith(" ") and entries:
                entries[-1].append(line.strip())
            else:
                entries.append([line.strip()])
    for first, *others in entries:
        head, colon, rest = first.partition(" : ")
        description = " ".join([rest, *others]).strip()
        yield (
            f"- `{head}`" + (f": {_plain(description)}" if description else "")
            if colon or others
            else f"- {_plain(first)}"
        )
    yield ""


def _plain(text: str) -> str:
    """Escape Markdown in a text, except in backquotes."""
    parts = re.split(r"(``.+?``|`[^`]+`)", text.strip())
    return "".join(
        part if part.startswith("`") else re.sub(r"([*_<>\[\]$|\\#])", r"\\\1", part) for part in parts
    )


def setup(app: Any) -> dict[str, bool]:
    """Write the pages before Sphinx reads them."""
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True}
