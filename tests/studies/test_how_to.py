"""The study file of the how-to page is read."""

import re
from pathlib import Path

from sarrus import mechanisms
from sarrus.model import load
from sarrus.studies.file import read_study_file

PAGE = (Path(__file__).parent.parent.parent / "docs/how-to/studies.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)


def test_file(tmp_path: Path) -> None:
    (block,) = blocks("yaml")
    (tmp_path / "springs.yaml").write_text(block)
    asked = read_study_file(tmp_path / "springs.yaml", lambda path: load(mechanisms.path("slider_crank")))
    assert asked.cases.shape == (20, 2)
