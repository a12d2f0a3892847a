"""Links and the reference of the documentation are complete, see also `test_guides`; what its theory derives."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import pytest

import sarrus as sr
from sarrus.cli import VERBS

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]
THEORY = {path.stem: path.read_text(encoding="utf-8") for path in (DOCS / "theory").glob("*.md")}
TUTORIAL = (DOCS / "tutorial.md").read_text(encoding="utf-8")


def test_the_stiffness_of_the_architecture_page() -> None:
    system = sr.System(sr.load("slider_crank"))
    place = system.parameter_names.index("spring[tsda].k")
    assert f"is now `b[{place}]`" in (DOCS / "architecture.md").read_text(encoding="utf-8")


def reference() -> ModuleType:
    """What writes the pages of the reference, which are not there before the documentation is built."""
    spec = importlib.util.spec_from_file_location("api_pages", DOCS / "api_pages.py")
    assert spec is not None
    assert spec.loader is not None
    pages = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(pages)
    return pages


def links(text: str) -> list[str]:
    """Targets of the links of a page, also over two lines, without code, other sites and anchors."""
    text = re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"`(?:[^`\n]|\n(?!\s*\n))*`", "", text)
    targets = re.findall(r"\]\(\s*([^)\s]+)\s*\)", text)
    return [target.partition("#")[0] for target in targets if not re.match(r"https?:|#", target)]


def links_of(page: Path) -> list[str]:
    return links(page.read_text(encoding="utf-8"))


def paths_in(text: str) -> set[str]:
    """Modules and folders that a page names in backticks, outside of code blocks."""
    text = re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE)
    return set(re.findall(r"`([a-z0-9_./-]+(?:\.py|/))`", text))


def test_paths_in_pages_exist() -> None:
    tops = ("src", "tests", "benchmarks", "docs", "examples", "distribution")
    files = [*ROOT.iterdir(), *(path for top in tops for path in (ROOT / top).rglob("*"))]
    known = {f"/{path.relative_to(ROOT).as_posix()}" for path in files}
    named = {(page.name, path) for page in PAGES for path in paths_in(page.read_text(encoding="utf-8"))}
    assert len(named) > 50
    assert [pair for pair in named if not any(one.endswith("/" + pair[1].strip("/")) for one in known)] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_to_files(page: Path) -> None:
    generated = {DOCS / "api" / f"{name}.md" for name in ("index", *reference().CHAPTERS)}
    targets = [(page.parent / target).resolve() for target in links_of(page)]
    assert [target for target in targets if not target.exists() and target not in generated] == []
    if page.is_relative_to(DOCS):  # a page outside is none of the site
        assert [
            target for target in targets if target.suffix == ".md" and not target.is_relative_to(DOCS)
        ] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_rows_of_tables_are_complete(page: Path) -> None:
    """A bar in a cell is written ``\\|``: otherwise it ends the cell, and the page lacks the rest."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    for table in re.findall(r"(?:^ *\|.*\n)+", text, re.MULTILINE):
        assert len({len(re.findall(r"(?<!\\)\|", row)) for row in table.splitlines()}) == 1, table


def test_links_are_seen() -> None:
    assert "../src/sarrus/system/system.py" in links_of(DOCS / "architecture.md")


def test_links_over_two_lines_are_seen() -> None:
    text = "`make\nwheel` of [a\npage](one.md), [`b`](two.md#here), [c](\n  three.md) and `[d](code.md)`.\n"
    assert links(text) == ["one.md", "two.md", "three.md"]


def test_every_decision_is_listed() -> None:
    folder = DOCS / "decisions"
    assert {path.name for path in folder.glob("0*.md")} == set(links_of(folder / "README.md"))


def test_the_model_file_of_the_tutorial(tmp_path: Path) -> None:
    (text,) = re.findall(r"^```yaml\n(.*?)^```", TUTORIAL, re.DOTALL | re.MULTILINE)
    (tmp_path / "four_bar.yaml").write_text(text)
    system = sr.System(sr.load(tmp_path / "four_bar.yaml"))
    assert sr.mobility(system, sr.assemble(system).q).degrees_of_freedom == 1


def test_the_reference_has_every_public_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pages = reference()
    monkeypatch.setattr(pages, "HERE", tmp_path)
    pages.write()
    text = "\n".join(page.read_text(encoding="utf-8") for page in (tmp_path / "api").iterdir())
    for name in sr.__all__:
        assert name.startswith("__") or f"\n## {name}\n" in text
    assert "### Trajectory.reaction" in text


def test_the_command_line_page_has_every_verb() -> None:
    page = (DOCS / "cli.md").read_text(encoding="utf-8")
    assert {verb for verb in VERBS if not re.search(rf"^\| `{verb}\b", page, re.MULTILINE)} == set()


def equations(text: str) -> set[int]:
    """The paper's equations that a text cites: (Eq. 8), (Eqs. 9, 10), (Eqs. 64 to 67; ...)."""
    found = set()
    for cited in re.findall(r"\(Eqs?\. ([^;)\n]*(?:\n[^;)\n]*)?)", text):
        for first, last in re.findall(r"(\d+)(?: to (\d+))?", cited):
            found |= set(range(int(first), int(last or first) + 1))
    return found


def test_the_theory_derives_every_equation_of_the_paper() -> None:
    assert set(range(1, 117)) - set().union(*map(equations, THEORY.values())) == set()
