"""The gallery's pages and the examples agree: none is missing, numbers are those of the references, commands run."""

from __future__ import annotations

import re
import runpy
import shlex
from pathlib import Path

import pytest
from tests.examples.problems import COLUMNS, FOLDER

from sarrus.cli import main

ROOT = FOLDER.parent
GRID = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
PAGES = {path.stem: path.read_text(encoding="utf-8") for path in (ROOT / "docs" / "gallery").glob("*.md")}
PAGE = "\n".join(PAGES[name] for name in sorted(PAGES))
PICTURES = re.findall(r"\]\(([\w-]+\.png)\)", PAGE)
COMMANDS = re.findall(r"^    sarrus (.*)$", PAGE, flags=re.MULTILINE)
ROWS = re.findall(r"^\| (.*?) \| (-?\d+\.\d{9}) \| (-?\d+\.\d{9}) \|$", PAGE, flags=re.MULTILINE)
HEAVIEST = 60_000  # bytes of a picture


def test_every_example_is_shown() -> None:
    assert {name for name in COLUMNS if f"examples/{name}.yaml" not in PAGE} == set()
    assert {name for name in COLUMNS if f"({name}-motion.png)" not in PAGE} == {"spatial_slider_crank_z"}


def test_the_grid_leads_to_every_page() -> None:
    assert set(re.findall(r"\]\(gallery/(\w+)\.md\)", GRID)) == set(PAGES)
    assert len(PAGES) > 20


def test_every_page_shows_its_model_or_script_and_its_picture() -> None:
    for name, page in PAGES.items():
        assert re.search(r"^```\{literalinclude\} \.\./\.\./", page, re.MULTILINE), name
        assert "](" in page.split("\n\n")[1], name


def test_every_script_is_shown_and_drawn() -> None:
    scripts = runpy.run_path(str(FOLDER / "gallery.py"))["SCRIPTS"]
    assert {path.stem for path in FOLDER.glob("*.py")} == {*scripts, "gallery", "four_bars"}
    assert [name for name in scripts if f"python examples/{name}.py" not in PAGE] == []


def test_pictures_are_there_and_light() -> None:
    sizes = {path: (ROOT / "docs" / "gallery" / path).stat().st_size for path in PICTURES}
    assert len(sizes) > 25
    assert max(sizes.values()) < HEAVIEST


def test_numbers_agree_with_the_references_and_the_script() -> None:
    entries = runpy.run_path(str(FOLDER / "gallery.py"))["ENTRIES"]
    known = sorted(f"{number:.9f}" for entry in entries.values() for number in entry.known.values())
    assert sorted(row[2] for row in ROWS) == known
    for name, found, wanted in ROWS:
        assert float(found) == pytest.approx(float(wanted), abs=5e-9), name


@pytest.mark.one_in(3)
@pytest.mark.parametrize("command", COMMANDS)
def test_commands_run_as_they_stand(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    words = shlex.split(command)
    words[1] = str(ROOT / words[1]) if "/" in words[1] else words[1]
    monkeypatch.chdir(tmp_path)
    assert main(words) == 0
    assert words[0] != "run" or (tmp_path / "run.png").is_file()


def test_the_script_draws_and_compares(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(FOLDER / "gallery.py"))["show"]("andrews", tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"andrews.png", "andrews-motion.png"}
    assert "| `gamma.angle` | 0.040822240 | 0.040822240 |" in capsys.readouterr().out
