"""The code of every page of the documentation runs, in an empty folder, and prints what the page shows."""

from __future__ import annotations

import webbrowser
from collections.abc import Iterator
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
from tests.pages import blocks, executed, has_code, printed, same
from tests.registries import registries_restored

import sarrus as sr
from sarrus.analyses.integration_methods import METHODS
from sarrus.outputs.output import PROVIDERS

ROOT = Path(__file__).parents[1]
PAGES = [
    page for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))] if page.parent.name != "api"
]
TEXTS = {page: page.read_text(encoding="utf-8") for page in PAGES}
RUN = [page for page in PAGES if has_code(page)]
QUICKER = {"workspace.md": {"cells=40": "cells=8"}}


@pytest.fixture(autouse=True)
def _alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Run in an empty folder without a browser; what a page registers is unknown to others."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(webbrowser, "open", lambda url: True)
    plt.switch_backend("agg")
    with registries_restored():
        yield


@pytest.mark.one_in(16)  # building the documentation runs all but README.md
@pytest.mark.parametrize("page", RUN, ids=[str(page.relative_to(ROOT)) for page in RUN])
def test_the_page(page: Path) -> None:
    executed(page, QUICKER.get(page.name))


def test_outputs_are_those_printed() -> None:
    assert printed("a 1.00001 m\n...\nb 2 ...\n", "x\na 1 m\ny\nb 2 c\n") == "a 1 m\n...\nb 2 ...\n"
    with pytest.raises(AssertionError, match="not printed"):
        printed("a 1.1 m", "a 1 m\n")
    with pytest.raises(AssertionError, match="not printed"):
        printed("b 2\na 1", "a 1\nb 2\n")
    assert not same("a 1 m", "a 1 s")


@pytest.mark.parametrize(
    "program", [pytest.param(name, marks=pytest.mark.needs(name)) for name in ("mujoco", "exudyn")]
)
def test_the_same_mechanism_in(program: str, capsys: pytest.CaptureFixture[str]) -> None:
    page = (ROOT / "docs" / "coming-from.md").read_text(encoding="utf-8")
    (code,) = [code for code in blocks(page, "py") if f"import {program}" in code]
    exec(compile(code, "coming-from.md", "exec"), {})
    assert float(capsys.readouterr().out.split()[-1]) == pytest.approx(-0.211565, abs=1e-6)


def test_the_model_file_of_the_same_mechanism(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "coming-from.md").read_text(encoding="utf-8")
    (tmp_path / "pendulum.yaml").write_text(*blocks(page, "yaml"), encoding="utf-8")
    run = sr.simulate(sr.System(sr.load(tmp_path / "pendulum.yaml")), until=2.0)
    assert run.joint("pin").angle[-1] == pytest.approx(-0.211565286, abs=1e-8)


def test_what_a_page_registers_is_forgotten() -> None:
    known = len(PROVIDERS), [*METHODS]
    with registries_restored():
        PROVIDERS.append(lambda system, part: iter(()))
        METHODS["bob"] = METHODS["radau"]
    assert known == (len(PROVIDERS), [*METHODS])
