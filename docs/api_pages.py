"""The API reference, generated from docstrings and annotations when the documentation is built.

`api/index.md` lists all public names by task with the first line of their docstrings; other pages have the details.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent

# page -> title, and its tasks: title -> the modules whose names belong to it, the first that fits
CHAPTERS: dict[str, tuple[str, dict[str, tuple[str, ...]]]] = {
    "models": (
        "Models",
        {
            "Models and bodies": (
                "model.model",
                "model.bodies",
                "model.file",
                "model.words",
                "model.geometry.solid",
            ),
            "Joints and couplings": ("model.joints",),
            "Drivers": ("model.drivers",),
            "Forces": ("model.forces",),
            "Points, frames and orientations": ("model.geometry",),
            "Laws and formulas": ("model.laws", "model.expression"),
            "Errors and warnings": ("model.errors",),
            "Other names": ("model",),
        },
    ),
    "import": ("Import of robot descriptions", {"Import": ("io",)}),
    "systems": ("Systems", {"Systems: the equations and their derivatives": ("system",)}),
    "positions": (
        "Assembly, kinematics, equilibrium and modes",
        {
            "Assembly and mobility": ("analyses.position", "analyses.redundancy"),
            "Prescribed motions": ("analyses.driven",),
            "Equilibrium and vibration": ("analyses.equilibria",),
        },
    ),
    "simulation": (
        "Simulation",
        {
            "Simulation": (
                "analyses.dynamics.simulation",
                "analyses.dynamics.time_loop",
                "analyses.dynamics.events",
            ),
            "Integration methods": ("analyses.dynamics.integrators",),
            "Integration methods of your own": ("analyses.dynamics",),
        },
    ),
    "sensitivity": (
        "Derivatives of motions",
        {"Responses": ("analyses.sensitivity.responses",), "Derivatives": ("analyses.sensitivity",)},
    ),
    "optimization": ("Optimization and parameter estimation", {"Optimization": ("analyses.optimization",)}),
    "workspaces": ("Workspaces", {"Workspaces": ("analyses.workspace",)}),
    "vehicles": ("Suspensions", {"Suspensions": ("vehicles",)}),
    "studies": (
        "Studies and uncertainty",
        {
            "Studies": ("studies.conduct", "studies.table", "studies.first_order"),
            "Parameters and samples": ("studies.parameters", "studies.samples"),
            "Analyses of a study": ("studies",),
        },
    ),
    "outputs": ("Outputs", {"Outputs": ("outputs",)}),
    "results": (
        "Results",
        {
            "Motions": ("results.motion", "results.reading"),
            "Verification": ("analyses.verification", "results.comparison"),
            "Derivatives and optima": ("results.gradient", "results.optimum"),
            "Maps of workspaces": ("results.maps",),
            "Other results": ("results", "analyses"),
        },
    ),
    "views": ("Pictures and animations", {"Pictures and animations": ("views",)}),
}
# methods that are public for other files of the package only, by the beginning of the module of their class
INNER = {
    "model": """primitives coordinates relations frames friction resolve law_measures limits contact follower
        ends distance pose rates mass_properties primitive looks look headline sections numbers exchanged
        written nodes""",
    "analyses.dynamics": "stepper scheme description run record operation state title",
    "analyses.position": "unchecked_along whole_along opens closes columns adjoint bend bend_of_motion",
    "analyses.optimization": "end_after is_late refuse_late restitutions_at expected limit took ends size slopes_along",
    "analyses.sensitivity": """pointwise output_label times coarse at_kinks by_times by_times_along weights
        weights_along rule rule_by_times evaluate outermost residuals title unit value""",
    "analyses.workspace": "of tried begin_at ray positions_outside",
    "vehicles": "headline",
    "studies": """result short found check begin started start_warnings described settings assembled grid at frozen
        points""",
    "outputs": "constant element scalars replayed local vector input",
    "results": "headline refuse_unknown to_store stored",
    "system": "headline compilable atoms magnitude matrix",
    "io": "headline looks sections",
}
SECTION = re.compile(r"^(\w[\w ]*)\n-{3,}\n", re.MULTILINE)
ARGUMENTS = ("Parameters", "Attributes", "Other Parameters")


def write(app: Any = None) -> None:
    """Write the index and one page for each chapter."""
    import sarrus

    folder = HERE / "api"
    folder.mkdir(exist_ok=True)
    homes = dict(_homes(sarrus))
    lost = [name for name in sarrus.__all__ if not name.startswith("__") and name not in homes]
    if lost:
        raise RuntimeError(f"these public names have no chapter in {__file__}: {', '.join(lost)}")
    index = ["# API reference", "", "All names are used as `sr.name` after `import sarrus as sr`.", ""]
    for page, (title, tasks) in CHAPTERS.items():
        tables: list[str] = []
        for task in tasks:
            names = sorted((name for name in homes if homes[name] == (page, task)), key=str.lower)
            heading = task if len(tasks) > 1 else ""
            tables += _table(heading, [(name, getattr(sarrus, name), page) for name in names])
        own = sorted((name for name in homes if homes[name][0] == page), key=str.lower)
        entries = (line for name in own for line in _entry(name, getattr(sarrus, name), homes))
        extra = _declared() if page == "outputs" else ()
        local = [line.replace(f"]({page}.md#", "](#") for line in tables]
        _update(folder / f"{page}.md", "\n".join([f"# {title}", "", *_lowered(local), *extra, *entries]))
        index += [f"## {title}", "", *_lowered(tables)]
    pages = ["```{toctree}", ":hidden:", "", *CHAPTERS, "```", ""]
    _update(folder / "index.md", "\n".join([*index, *pages]))


def _homes(sarrus: Any) -> Iterator[tuple[str, tuple[str, str]]]:
    """The page and task of every public name."""
    places = [
        (prefix, page, task)
        for page, (_, tasks) in CHAPTERS.items()
        for task, prefixes in tasks.items()
        for prefix in prefixes
    ]
    for name in sarrus.__all__:
        module = _module(getattr(sarrus, name))
        fits = [place for place in places if (module + ".").startswith(place[0] + ".")]
        if fits and not name.startswith("__"):
            _, page, task = max(fits, key=lambda place: len(place[0]))
            yield name, (page, task)


def _module(what: Any) -> str:
    """The module that defines an object, in the package; an object without a module is the ground."""
    module = str(getattr(what, "__module__", ""))
    return module.removeprefix("sarrus.") if module.startswith("sarrus.") else "model.geometry.solid"


def _lowered(tables: list[str]) -> list[str]:
    """Titles of tables as bold text, so that they are no sections of their own."""
    return [f"**{line[3:]}**" if line.startswith("## ") else line for line in tables]


def _table(title: str, rows: list[tuple[str, Any, str]]) -> list[str]:
    """Names with links, their kind, and the first line of their docstrings."""
    if not rows:
        return []
    lines = [
        f"| [`{name}`]({page}.md#{name.lower()}) | {_kind(what)} | {_summary(name, what)} |"
        for name, what, page in rows
    ]
    return [*([f"## {title}", ""] if title else []), "| name | kind | summary |", "|---|---|---|", *lines, ""]


def _kind(what: Any) -> str:
    if inspect.isclass(what):
        return "exception" if issubclass(what, BaseException) else "class"
    return "function" if inspect.isfunction(what) else "object"


def _summary(name: str, what: Any) -> str:
    """The first paragraph of a docstring, in one line of a table."""
    if getattr(what, "__name__", name) != name:
        return f"Another name of `{what.__name__}`."
    doc = inspect.getdoc(what if _kind(what) != "object" else type(what)) or ""
    return _cell(" ".join(doc.split("\n\n")[0].split()))


def _cell(text: str) -> str:
    """A text for a cell of a table."""
    return _plain(text).replace("|", r"\|").replace(r"\\|", r"\|")


def _declared() -> Iterator[str]:
    """A table of what forces declare as outputs, with the beginning of its description."""
    import sarrus
    from sarrus.elements import BUILT_IN

    kinds = {kind.__name__: kind for kind in BUILT_IN if kind.outputs and hasattr(sarrus, kind.__name__)}
    common = {one.word for one in kinds["Bushing"].outputs.values()}
    inherited = {one.method for one in kinds["Bushing"].outputs.values()}
    yield from ("## Outputs of forces", "", "| force | output | unit | meaning |", "|---|---|---|---|")
    rows = [("every force", kinds["Bushing"], one) for one in kinds["Bushing"].outputs.values()]
    rows += [
        (f"[`{name}`](models.md#{name.lower()})", kind, one)
        for name, kind in sorted(kinds.items())
        for one in kind.outputs.values()
        if one.word not in common or one.method not in inherited
    ]
    for name, kind, one in rows:
        words = ", ".join(f"`.{one.word}.{axis}`" for axis in one.axes) or f"`.{one.word}`"
        meaning = _cell((inspect.getdoc(getattr(kind, one.method)) or "").split("\n\n")[0])
        yield f"| {name} | {words} | {one.unit} | {meaning} |"
    yield ""


def _update(path: Path, text: str) -> None:
    """Write a page only if it has changed, so that Sphinx does not read it again."""
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def _entry(name: str, what: Any, homes: dict[str, tuple[str, str]]) -> Iterator[str]:
    yield f"## {name}\n"
    if _kind(what) == "object":
        yield f"`sarrus.{name}`: {_plain(type(what).__doc__ or '')}\n"
        return
    yield f"```py\nsarrus.{name}{_signature(what)}\n```\n"
    if what.__name__ != name:
        yield f"Another name of [`{what.__name__}`](#{what.__name__.lower()}).\n"
        return
    yield from _markdown(_documented(what), _types(what), homes)
    if not inspect.isclass(what):
        return
    members = list(_members(what))
    if members:
        yield "| member | summary |\n|---|---|"
        for own, member in members:
            call = "" if isinstance(member, property) else "()"
            yield f"| [`{own}{call}`](#{name.lower()}-{own.lower()}) | {_summary_of_member(member)} |"
        yield ""
    for own, member in members:
        arguments = "" if isinstance(member, property) else _signature(member)
        yield f"({name.lower()}-{own.lower()})=\n### {name}.{own}\n"
        yield f"```py\n{name}.{own}{arguments}\n```\n"
        types = {} if isinstance(member, property) else _types(member)
        yield from _markdown(inspect.getdoc(member) or "", types, homes)


def _documented(what: Any) -> str:
    """The docstring; that of a class with the parameters that only its base classes describe."""
    from sarrus.model.registry import described

    return described(what) if inspect.isclass(what) else inspect.getdoc(what) or ""


def _summary_of_member(member: Any) -> str:
    return _cell(" ".join((inspect.getdoc(member) or "").split("\n\n")[0].split()))


def _types(what: Any) -> dict[str, tuple[str, str]]:
    """Type and default of every parameter, as text; a type that is an alias of its module is written out."""
    try:
        found = inspect.signature(what).parameters.values()
    except (TypeError, ValueError):
        return {}
    scope = getattr(inspect.getmodule(what), "__dict__", {})
    return {p.name: (_type(p.annotation, scope), _default(p)) for p in found}


def _type(annotation: Any, scope: dict[str, Any]) -> str:
    if annotation is inspect.Parameter.empty:
        return ""
    text = annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)
    text = re.sub(r"Annotated\[(\w+), .*\]", r"\1", text)

    def written_out(found: re.Match[str]) -> str:
        alias = scope.get(found.group())
        return inspect.formatannotation(alias) if hasattr(alias, "__args__") else found.group()

    text = re.sub(r"\b[A-Z]\w*\b", written_out, text)
    text = re.sub(r"ForwardRef\('(.*?)'\)", r"\1", text)
    text = re.sub(r"\b(?:[a-z_]\w*\.)+(?=[A-Za-z])|~", "", text)  # modules
    text = re.sub(r"\bndarray\[.*?dtype\[\w*\]\]|\bNDArray\[[^\]]*\]", "array", text).replace(
        "ArrayLike", "array_like"
    )
    return text if len(text) < 70 else ""


def _default(parameter: inspect.Parameter) -> str:
    if parameter.default is inspect.Parameter.empty:
        return ""
    text = _clean(repr(parameter.default))
    return "" if "..." in text else text


def _signature(what: Any) -> str:
    try:
        found = inspect.signature(what)
    except (TypeError, ValueError):
        return "(...)"
    shown = [
        p.replace(annotation=inspect.Parameter.empty) for p in found.parameters.values() if p.name != "self"
    ]
    text = _clean(str(inspect.Signature(shown)))
    if len(text) < 75:
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
    inner = {
        name for part, names in INNER.items() if _module(what).startswith(part) for name in names.split()
    }
    for base in what.__mro__:
        if base.__module__.startswith("sarrus."):
            for name, member in vars(base).items():
                plain = getattr(member, "__func__", member)
                good = inspect.isfunction(plain) or isinstance(plain, property)
                if (
                    good
                    and not name.startswith("_")
                    and name not in seen | inner
                    and _is_current(plain.__doc__)
                ):
                    seen.add(name)
                    yield name, plain


def _is_current(doc: str | None) -> bool:
    """Whether a member is described, and not as a deprecated name."""
    return bool(doc) and "deprecated name" not in str(doc)


def _markdown(
    doc: str, types: dict[str, tuple[str, str]], homes: dict[str, tuple[str, str]]
) -> Iterator[str]:
    """A numpydoc docstring as Markdown: paragraphs, a table of parameters, and a list for each other section."""
    pieces = SECTION.split(doc)
    yield _plain(pieces[0].strip()) + "\n"
    for title, body in zip(pieces[1::2], pieces[2::2], strict=True):
        yield f"**{title}**\n"
        if title in ARGUMENTS:
            yield from _arguments(body, types, homes)
        elif title in ("Notes", "Examples"):
            yield _plain(body.strip()) + "\n"
        else:
            yield from _list(body, homes)


def _items(body: str) -> Iterator[tuple[str, str]]:
    """Items ``name : description``, or ``name`` with indented lines below it."""
    entries: list[list[str]] = []
    for line in body.splitlines():
        if line.strip():
            if line.startswith(" ") and entries:
                entries[-1].append(line.strip())
            else:
                entries.append([line.strip()])
    for first, *others in entries:
        head, _, rest = first.partition(" : ")
        yield head, " ".join([rest, *others]).strip()


def _arguments(
    body: str, types: dict[str, tuple[str, str]], homes: dict[str, tuple[str, str]]
) -> Iterator[str]:
    """A table of parameters with their types and defaults."""
    yield "| name | type | default | description |\n|---|---|---|---|"
    for head, description in _items(body):
        known = [types.get(name.strip().lstrip("*"), ("", "")) for name in head.split(",")]
        kinds = dict.fromkeys(kind for kind, _ in known if kind)
        defaults = dict.fromkeys(default for _, default in known if default)
        if description in homes and description in kinds:
            description = ""
        shown = ", ".join(_linked(kind, homes) for kind in kinds)
        values = ", ".join(f"`{value}`" for value in defaults)
        yield f"| `{head}` | {shown} | {values} | {_cell(description)} |"
    yield ""


def _linked(kind: str, homes: dict[str, tuple[str, str]]) -> str:
    """A type with links from its public names to their entries."""
    pieces = re.split(r"\b(" + "|".join(map(re.escape, homes)) + r")\b", kind)
    return "".join(
        f"[`{piece}`]({homes[piece][0]}.md#{piece.lower()})" if n % 2 else _cell(piece)
        for n, piece in enumerate(pieces)
    )


def _list(body: str, homes: dict[str, tuple[str, str]]) -> Iterator[str]:
    for head, description in _items(body):
        name = _linked(head, homes) if head in homes else f"`{head}`" if description else _plain(head)
        yield f"- {name}" + (f": {_plain(description)}" if description else "")
    yield ""


def _plain(text: str) -> str:
    """Escape Markdown in a text, except in backquotes."""
    parts = re.split(r"(``.+?``|`[^`]+`)", text)
    return "".join(
        part if part.startswith("`") else re.sub(r"([*_<>\[\]$|\\#])", r"\\\1", part) for part in parts
    )


def setup(app: Any) -> dict[str, bool]:
    """Write the pages before Sphinx reads them."""
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True}
