"""One notebook that displays a result of every kind, executed by a kernel of its own."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path
from typing import Any

import pytest

nbclient = pytest.importorskip("nbclient", reason='needs the extra "test"')
nbformat = pytest.importorskip("nbformat")

CELLS = {
    "Model": 'import sarrus as sr\nmodel = sr.load("slider_crank")\nmodel',
    "System": "system = sr.System(model)\nsystem",
    "Mobility": "sr.mobility(system)",
    "Assembly": "start = sr.assemble(system)\nstart",
    "Trajectory": 'run = sr.simulate(system, start, until=0.5, store="steps")\nrun',
    "EnergyBalance": "run.energy_balance()",
    "Gradient": 'sr.sensitivity(run, sr.Final("slider.x"), ["spring.k", "rod.mass"])',
    "Hessian": 'sr.hessian(run, sr.Final("slider.x"), ["spring.k", "spring.length"])',
    "Equilibrium": "rest = sr.equilibrium(system)\nrest",
    "Modes": "sr.modes(system, rest)",
    "StudyTable": 'sr.study(model, {"spring.k": [8, 12]}, "slider.x", analysis=sr.Simulation(until=0.1), workers=1)',
    "Optimum": """box = {"spring.k": (5, 20)}
sr.optimize(system, sr.Final("slider.x"), ["spring.k"], until=0.2, bounds=box)""",
    "Fit": """from dataclasses import replace
data = tuple(run.output("slider.x").values[-2:])
misfit = sr.Misfit("slider.x", at=tuple(run.t[-2:]), data=data, sigma=1e-3)
sr.fit(system, misfit, ["spring.k"])""",
    "Workspace": """links = [sr.Body(f"link_{n}", 1, (1, 1, 1), position=(n, 0, 0)) for n in (0, 1)]
places = zip((sr.ground, links[0]), links)
joints = [sr.Revolute(f"q{n}", *two, point=(n, 0, 0), axis=(0, 0, 1)) for n, two in enumerate(places)]
arm = sr.System(sr.Model("arm", links, joints))
sr.workspace(arm, links[1].point(0.6, 0, 0)["x", "y"], limits={"q0": (-1, 1), "q1": (0.2, 1.5)})""",
    "WorkspaceRange": 'sr.workspace_range(system, "slider.x")',
    "part": 'run["spring"]',
    "page": "run.animate()",
}
PICTURES = {
    "Model", "System", "Trajectory", "Gradient", "Modes", "StudyTable", "Optimum", "Fit", "Workspace",
}  # fmt: skip
TABLES = {*PICTURES, "Assembly", "EnergyBalance", "Hessian"}
CELL_TEXTS = {
    "Assembly": ["slider", "x [m]", "4.17"],
    "Optimum": ["variable", "spring.k", "N/m"],
    "StudyTable": ["spring.k [N/m]", "slider.x [m]"],
    "Workspace": ["component 1", "m²", "link_1(0.6, 0, 0).x [m]", "q1"],
    "page": ["iframe"],
}


@cache
def shown() -> dict[str, dict[str, str]]:
    """What every cell displays, by type of text."""
    cells = [nbformat.v4.new_code_cell(source) for source in CELLS.values()]
    notebook = nbformat.v4.new_notebook(cells=cells)
    found = nbclient.NotebookClient(notebook, timeout=600, kernel_name="python3").execute()
    if folder := os.environ.get("SARRUS_PICTURES"):
        nbformat.write(found, Path(folder) / "results.ipynb")
    return dict(zip(CELLS, map(_displayed, found.cells), strict=True))


def _displayed(cell: Any) -> dict[str, str]:
    (last,) = (one for one in cell.outputs if one.output_type == "execute_result")
    return dict(last.data)


@pytest.mark.parametrize("kind", CELLS)
def test_every_kind_of_result_is_displayed(kind: str) -> None:
    data = shown()[kind]
    text, page = data["text/plain"], data.get("text/html", "")
    name = {"Fit": "Optimum", "part": "PartMotion", "page": "Page"}.get(kind, kind)
    assert text.startswith((f"<{name} ", f"{name}("))
    assert len(text) < (900 if kind == "part" else 160)
    assert "\n" not in text
    assert bool(page) == (kind != "part")
    assert page.count("<svg") == (kind in PICTURES)
    assert ("<table>" in page) == (kind in TABLES)
    assert all(one in page for one in CELL_TEXTS.get(kind, []))
    assert "object at 0x" not in page


def test_progress_leaves_nothing_in_a_notebook() -> None:
    source = """import time
from sarrus.activity import activity, for_seconds
print("before")
for _ in range(2):
    with activity(for_seconds("working")):
        time.sleep(1.3)
print("after")"""
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(source)])
    (cell,) = nbclient.NotebookClient(notebook, timeout=60, kernel_name="python3").execute().cells
    text = "".join(one.get("text") or one.data["text/plain"] for one in cell.outputs)
    assert text == "before\nafter\n"
    assert {one.get("name", "stdout") for one in cell.outputs} == {"stdout"}
    assert any(one.output_type == "display_data" for one in cell.outputs)  # where the line was
