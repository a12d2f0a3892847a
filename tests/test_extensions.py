"""The examples of docs/extending.md, one file for each kind of part, are added from outside of the package and used."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.registries import registries_restored

import sarrus as sr
from sarrus.cli import extensions, main
from sarrus.model.file import schema_text
from sarrus.model.geometry.rotation import matrix

PAGE = (Path(__file__).parent.parent / "docs" / "extending.md").read_text(encoding="utf-8")
EXAMPLES = dict(re.findall(r"^```py\n# (\w+\.py)\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE))
SADDLE = """
from dataclasses import dataclass
from saddle import OnSaddle
from sarrus import model
from sarrus.model.primitive import Primitive

@dataclass(frozen=True, eq=False)
class Saddle(model.Joint):
    point: model.Point
    k: float

    def primitives(self, poses):
        at = self.point.resolve(poses, "point")
        yield Primitive(OnSaddle, (at.body,), (at.s, self.k), "saddle")
"""
MODEL = """
name: extended
gravity: [0, 0, -9.81]
parameters: {g: 2 N m^2, half: g/2}
bodies:
  slider: {mass: 1, inertia: [0.01, 0.02, 0.03], position: [0.2, 0.1, 0]}
  moon: {mass: 2, inertia: [0.02, 0.01, 0.03], position: [1.5, 0.6, 0.2]}
  ball: {mass: 0.5, inertia: [0.01, 0.01, 0.01], position: [0.3, 0.2, 0.06]}
joints:
  slot: {type: pin_in_slot, bodies: [ground, slider], point: [0, 0, 0], axis: [0, 0, 1]}
  dish: {type: saddle, point: {body: ball, at: [0, 0, 0]}, k: 1}
drivers:
  lift: {type: height, point: {body: moon, at: [0, 0, 0]}, motion: 20 cm + 10 cm * sin(2*t)}
forces:
  pull: {type: attraction, points: [{body: slider, at: [0.1, 0, 0]}, {body: moon, at: [0, 0, 0]}], strength: 2*half}
"""
UNTIL = 0.3


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The examples as files of a user, and a model that uses them."""
    made = tmp_path_factory.mktemp("extensions")
    for name, text in {
        **EXAMPLES,
        "saddle_joint.py": SADDLE,
        "all.yaml": MODEL,
        "long.bob": "2.0 3.0",
    }.items():
        (made / name).write_text(text, encoding="utf-8")
    return made


@pytest.fixture(scope="module", autouse=True)
def loaded(folder: Path) -> Iterator[None]:
    """The extensions are there for the tests of this module only."""
    known = {path.stem for path in folder.glob("*.py")}
    with registries_restored(), pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", list(sys.path))
        patch.setenv(extensions.VARIABLE, os.pathsep.join(str(path) for path in sorted(folder.glob("*.py"))))
        extensions.load_extensions()
        yield
    for name in known:
        sys.modules.pop(name, None)


@pytest.fixture(scope="module")
def run(folder: Path) -> sr.Trajectory:
    return simulated(folder)


def simulated(folder: Path, *events: sr.Event, **parameters: Any) -> sr.Trajectory:
    system = sr.System(sr.load(folder / "all.yaml", parameters=parameters))
    steps = {
        "method": sr.Radau(first_step=UNTIL / 100, max_step=UNTIL / 100, rtol=0.1, atol=0.1)
    }  # equal in all runs
    return sr.simulate(system, until=UNTIL, store="steps", events=events, **steps)


def test_every_example_is_used() -> None:
    assert {"pin_in_slot.py", "saddle.py", "attraction.py", "height.py"} <= set(EXAMPLES)
    assert {"square_integral.py", "distance.py", "implicit_euler.py", "bob.py", "weigh.py"} <= set(EXAMPLES)


def test_a_model_file_and_its_schema_have_them(folder: Path) -> None:
    model = sr.load(folder / "all.yaml")
    kinds = [type(part).__name__ for part in (*model.joints, *model.drivers, *model.forces)]
    assert kinds == ["PinInSlot", "Saddle", "HeightDriver", "Attraction"]
    schema = schema_text()
    assert all(f'"const": "{kind}"' in schema for kind in ("pin_in_slot", "saddle", "height", "attraction"))


def test_a_model_file_is_written_with_them(folder: Path) -> None:
    model = sr.load(folder / "all.yaml")
    replace(model, origin=None).save(folder / "written.yaml")
    systems = [sr.System(one) for one in (model, sr.load(folder / "written.yaml"))]
    for name in ("q0", "v0", "b"):
        assert getattr(systems[0], name).tobytes() == getattr(systems[1], name).tobytes()
    assert systems[0].parameter_names == systems[1].parameter_names
    text = (folder / "written.yaml").read_text(encoding="utf-8")
    assert "type: pin_in_slot" in text
    assert "strength: 2*half" in text


@pytest.mark.slow
def test_derivatives_agree_with_independent_ones(run: sr.Trajectory) -> None:
    report = run.system.check_derivatives()
    assert report, report
    assert sr.mobility(run.system, run.q[0]).degrees_of_freedom == 18 - 4 - 1 - 1


def test_the_motion_is_that_of_the_definitions(run: sr.Trajectory) -> None:
    slider, moon, ball = run["slider"], run["moon"], run["ball"]
    A = np.array([matrix(p) for p in slider.euler])
    pin = slider.position + A @ np.array([-0.2, -0.1, 0.0])
    np.testing.assert_allclose(pin[:, 1:], 0, atol=1e-9)
    np.testing.assert_allclose(A[:, :, 2], np.tile([0, 0, 1], (len(run.t), 1)), atol=1e-9)
    np.testing.assert_allclose(moon.position[:, 2], 0.2 + 0.1 * np.sin(2 * run.t), atol=1e-9)
    x, y, z = ball.position.T
    np.testing.assert_allclose(z, x * y, atol=1e-9)
    d = moon.position - slider.position - A @ np.array([0.1, 0.0, 0.0])
    np.testing.assert_allclose(run["pull.pull"], 2 / np.sum(d * d, axis=1), rtol=1e-9)
    np.testing.assert_allclose(run["ball.distance"], np.linalg.norm(ball.position, axis=1), rtol=1e-9)
    np.testing.assert_allclose(run["slot.displacement"], pin[:, 0], atol=1e-9)


def test_gradients_are_exact(run: sr.Trajectory, folder: Path) -> None:
    from square_integral import SquareIntegral  # type: ignore[import-not-found]

    responses = [
        SquareIntegral("ball.distance"),
        SquareIntegral("slider.x"),
        sr.Final("pull.pull"),
        sr.Final("moon.distance"),
    ]
    wrt = ["g", "dish.k", "slider.mass"]
    direct, adjoint = (sr.sensitivity(run, responses, wrt, method=method) for method in ("direct", "adjoint"))
    np.testing.assert_allclose(direct.matrix, adjoint.matrix, rtol=1e-9, atol=1e-11)
    square = np.interp(times := np.linspace(0, UNTIL, 2001), run.t, run["slider"].position[:, 0]) ** 2
    assert direct.values[1] == pytest.approx(np.trapezoid(square, times), rel=1e-4)
    assert direct.response_units[1] == "m² s"
    one, other = (sr.sensitivity(simulated(folder, g=2 + e), responses, ["g"]).values for e in (1e-4, -1e-4))
    np.testing.assert_allclose(direct.matrix[:, 0], (one - other) / 2e-4, rtol=1e-6, atol=1e-8)


@pytest.mark.slow
def test_hessians_are_exact(folder: Path) -> None:
    """With an event at the end, whose time depends on the parameter."""
    from square_integral import SquareIntegral

    response, stop = SquareIntegral("slider.x"), sr.Event("slider.x - 0.23", terminal=True)
    gradients = [
        sr.sensitivity(simulated(folder, stop, g=2 + e), response, ["g", "slider.mass"])
        for e in (1e-4, -1e-4)
    ]
    run = simulated(folder, stop)
    assert run.t[-1] < UNTIL
    hessian = sr.hessian(run, response, ["g", "slider.mass"]).matrix[:, 0]
    differences = (gradients[0].matrix[0] - gradients[1].matrix[0]) / 2e-4
    np.testing.assert_allclose(hessian, differences, rtol=1e-6, atol=1e-8)


def test_a_method_runs_them_with_gradients(folder: Path) -> None:
    from implicit_euler import euler  # type: ignore[import-not-found]

    system = sr.System(sr.load(folder / "all.yaml"))
    found = sr.simulate(
        system,
        until=0.05,
        method=sr.DescribedMethod(euler(), first_step=1e-3, max_step=1e-3, rtol=0.1, atol=0.1),
        store="steps",
    )
    exact = sr.simulate(system, until=0.05, method=sr.Radau(rtol=1e-10, atol=1e-12))
    error = np.abs(found.q[-1] - exact.q[-1]).max()
    assert 1e-7 < error < 1e-3  # of order one
    responses, wrt = [sr.Final("slider.x"), sr.Final("pull.pull")], ["g", "slider.mass"]
    direct, adjoint = (
        sr.sensitivity(found, responses, wrt, method=method) for method in ("direct", "adjoint")
    )
    np.testing.assert_allclose(direct.matrix, adjoint.matrix, rtol=1e-8, atol=1e-12)
    assert np.all(direct.matrix != 0)


def test_a_saved_run_is_read(run: sr.Trajectory, folder: Path, tmp_path: Path) -> None:
    system = run.system
    saved = sr.simulate(system, until=0.1, save=tmp_path / "run.sarrus")
    again = sr.load_run(tmp_path / "run.sarrus", system)
    np.testing.assert_array_equal(again["pull.pull"], saved["pull.pull"])


def told(capsys: pytest.CaptureFixture[str], *words: str) -> Any:
    assert main([*words, "--json", "--quiet"]) == 0
    return json.loads(capsys.readouterr().out)


def test_the_command_line_has_them(folder: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file, table = str(folder / "all.yaml"), tmp_path / "run.csv"
    assert told(capsys, "weigh", file)["mass"] == 3.5
    assert told(capsys, "weigh", str(folder / "long.bob"))["mass"] == 3.0
    until = ("--until", "0.05", "--steps", "2")
    told(capsys, "run", file, *until, "--csv", str(table), "--columns", "pull.pull", "ball.distance")
    assert "pull.pull [N]" in table.read_text().splitlines()[0]
    found = told(capsys, "run", str(folder / "long.bob"), *until)
    assert found["bodies"]["bob"]["position"][2] == pytest.approx(-9.81 * 0.05**2 / 2, rel=1e-2)
    assert "weigh" in told(capsys, "completion", "bash")["script"]
    assert told(capsys, "sensitivity", file, *until[:2], "--response", "pull.pull", "--wrt", "g")


@pytest.mark.slow
def test_a_method_has_its_name_everywhere(
    folder: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """The command line, files of studies with options, and studies in other processes."""
    file, until = str(folder / "all.yaml"), ("--until", "0.01")
    chosen = (*until, "--method", "euler", "--rtol", "1e-3", "--atol", "1e-3")
    exact, found = told(capsys, "run", file, *until), told(capsys, "run", file, *chosen)
    ends = [one["bodies"]["slider"]["position"][0] for one in (exact, found)]
    assert 1e-9 < abs(ends[1] - ends[0]) < 1e-3
    gradient = told(capsys, "sensitivity", file, *chosen, "--response", "slider.x", "--wrt", "g")
    (response,) = gradient["responses"].values()
    assert response["value"] == pytest.approx(ends[1], abs=1e-6)
    run = {"type": "simulate", "until": 0.01, "rtol": 1e-3, "atol": 1e-3}
    tables = [
        sr.study(
            sr.load(file), {"g": [1.0, 2.0]}, {"x": "final(slider.x)"}, workers=workers, folder=tmp_path / name,
            analysis={**run, "method": {"type": "euler", "name": name}},
        )
        for workers, name in ((1, "here"), (2, "there"))
    ]  # fmt: skip
    assert all(table.success.all() for table in tables)
    np.testing.assert_array_equal(*(table["x"] for table in tables))
    assert tables[0]["x"][1] == pytest.approx(ends[1], abs=1e-6)
    with pytest.raises(sr.SarrusError, match=r"the method euler: name must be a text, but is 3"):
        sr.study(sr.load(file), {"g": [1.0]}, {"x": "final(slider.x)"},
                 analysis={**run, "method": {"type": "euler", "name": 3}})  # fmt: skip


def test_extensions_of_a_fresh_process(folder: Path, tmp_path: Path) -> None:
    """One by its file, one by the entry point of an installed package."""
    package = tmp_path / "weighing-1.0.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: weighing\nVersion: 1.0\n")
    (package / "entry_points.txt").write_text("[sarrus]\nweigh = weigh\n")
    (tmp_path / "weigh.py").write_text(EXAMPLES["weigh.py"])
    paths = os.pathsep.join([str(tmp_path), *sys.path])
    environment = {**os.environ, "PYTHONPATH": paths, extensions.VARIABLE: str(folder / "bob.py")}
    command = [sys.executable, "-m", "sarrus", "weigh", str(folder / "long.bob")]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "long: 3 kg\n", "")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "is missing, or has the name of another module"),
        ("1 / 0", "ZeroDivisionError: division by zero"),
        (EXAMPLES["weigh.py"], "there is already a verb check. Rename the module."),
    ],
)
def test_a_wrong_extension_is_one_message(
    text: str | None,
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    file = tmp_path / ("json.py" if text is None else "check.py")
    if text is not None:
        file.write_text(text)
    monkeypatch.setenv(extensions.VARIABLE, str(file))
    monkeypatch.setattr(sys, "path", list(sys.path))
    assert main(["schema"]) == 2
    sys.modules.pop("check", None)
    err = capsys.readouterr().err
    assert err.startswith(f"sarrus: extension {file.stem}: ")
    assert message in err
    assert err.count("\n") == 1
