"""Models and results are one line in a console, and a table with a picture in a notebook."""

from __future__ import annotations

from functools import cache
from html.parser import HTMLParser

import numpy as np
import pytest

import sarrus as sr
from sarrus import mechanisms
from sarrus.views import notebook

VOID = {"meta", "br", "hr"}


class Balanced(HTMLParser):
    """Fails where tags do not match."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.counts: dict[str, int] = {}

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.counts[tag] = self.counts.get(tag, 0) + 1
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: object) -> None:
        self.counts[tag] = self.counts.get(tag, 0) + 1

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def read(page: str) -> Balanced:
    found = Balanced()
    found.feed(page)
    assert not found.open
    return found


@cache
def shown() -> dict[str, object]:
    """One of each."""
    model = sr.load(mechanisms.path("slider_crank"))
    system = sr.System(model)
    start = sr.assemble(system)
    run = sr.simulate(system, start, until=0.5, store="steps")
    balance = sr.equilibrium(system)
    cases = {"spring.k": [8.0, 10.0, 12.0]}
    return {
        "Model": model,
        "System": system,
        "Assembly": start,
        "Trajectory": run,
        "Gradient": sr.sensitivity(run, sr.Final("slider.x")),
        "Hessian": sr.hessian(run, sr.Final("slider.x"), ["spring.k", "spring.length"]),
        "Mobility": sr.mobility(system),
        "Equilibrium": balance,
        "Modes": sr.modes(system, balance.q),
        "StudyTable": sr.study(model, cases, "slider.x", analysis=sr.Simulation(until=0.1), workers=1),
    }


PICTURES = {"Model", "System", "Trajectory", "Gradient", "Modes", "StudyTable"}
CELLS = {
    "Model": ["crank", "1 kg", "ground, slider", "TSDA"],
    "Trajectory": ["slider", "body, at the end"],
    "Gradient": ["spring.k", "N/m", " more"],
    "Hessian": ["spring.length"],
    "Modes": ["0.407171"],
    "StudyTable": ["spring.k", "12"],
}


@pytest.mark.one_in(8)
@pytest.mark.parametrize("kind", [*CELLS, "System", "Assembly", "Mobility", "Equilibrium"])
def test_one_line_and_a_page(kind: str) -> None:
    one = shown()[kind]
    line, page = repr(one), one._repr_html_()  # type: ignore[attr-defined]
    assert line.startswith(f"<{kind} ")
    assert line.endswith(">")
    assert len(line) < 160
    assert "\n" not in line
    assert read(page).counts.get("svg", 0) == (kind in PICTURES)
    assert all(cell in page for cell in CELLS.get(kind, []))


def test_joints_are_of_bodies_not_of_points() -> None:
    table = notebook.table_of(shown()["Model"])
    assert table is not None
    assert ("pin", "Revolute", "ground, crank") in table.rows


def test_notebooks_show_no_figure_twice() -> None:
    from matplotlib import pyplot

    before = pyplot.get_fignums()
    for one in shown().values():
        one._repr_html_()  # type: ignore[attr-defined]
    assert pyplot.get_fignums() == before


def test_without_matplotlib_there_is_no_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(notebook, "find_spec", lambda name: None)
    page = shown()["Gradient"]._repr_html_()  # type: ignore[attr-defined]
    assert "<svg" not in page
    assert "spring.k" in page


def test_names_are_text_and_repetitions_a_table() -> None:
    body = sr.Body("b", mass=1.0, inertia=(1, 1, 1))
    pins = [sr.Revolute(name, sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0)) for name in ("one", "two")]
    model = sr.Model("<script>", [body], pins)
    page = model._repr_html_()
    assert "script" not in read(page).counts
    assert "&lt;script&gt;: 1 body, 2 joints" in page
    doubled = sr.mobility(sr.System(model))._repr_html_()
    assert "repeats" in doubled
    assert "rotation about" in doubled


def test_round_off_is_shown_as_zero() -> None:
    body = sr.Body("b", mass=1.0, inertia=(1, 1, 1), position=(1.0, 1e-17, 0.0))
    run = sr.simulate(sr.System(sr.Model("still", [body])), until=0.1)
    assert "e-17" not in run._repr_html_()
    assert np.isclose(run.q[-1, 1], 1e-17)
