"""Arguments of wrong kinds, names that no file can have, and numbers without digits: one message that names them."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sarrus as sr

NAMES = ["a\0b", "a" * 5000, "a/" * 3000 + "b"]


def system() -> sr.System:
    return sr.System(sr.load("slider_crank"))


def body(**given: Any) -> sr.System:
    one = sr.Body("b", **{"mass": 1.0, "inertia": (1, 1, 1), **given})
    return sr.System(sr.Model("m", [one]))


@pytest.mark.parametrize("name", NAMES, ids=["NUL", "long", "deep"])
def test_names_that_no_file_can_have(name: str) -> None:
    run = sr.simulate(system(), until=0.01)
    calls: list[Callable[[], Any]] = [
        lambda: run.to_csv(f"{name}.csv"),
        lambda: run.save(name),
        lambda: run.animate(f"{name}.html"),
        lambda: run.system.model.save(f"{name}.yaml"),
        lambda: sr.export(run.system.model, f"{name}.xml"),
        lambda: sr.load(f"{name}.yaml"),
        lambda: sr.load_run(name),
        lambda: sr.resume(name),
        lambda: sr.open_study(name),
    ]
    for call in calls:
        with pytest.raises(sr.SarrusError) as raised:
            call()
        assert len(str(raised.value)) > 20


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: body(mass=np.array([1.0, 2.0])), 'body "b": mass must be a number, but is'),
        (lambda: body(mass=5e-324), 'body "b": mass is too small, it is'),
        (lambda: body(position=(5e-324, 0, 0)), 'body "b": position is too small'),
        (lambda: sr.simulate(system(), until=1.0, inputs=lambda t: t), "inputs must be a mapping"),
        (lambda: sr.linearize(system(), system().q0, inputs="u"), "inputs must be a list of names"),
        (
            lambda: sr.simulate(system(), until=1.0, method=sr.Radau(max_step=1e-320)),
            "max_step is 1e-320 s, less than the",
        ),
        (
            lambda: sr.System(
                sr.Model(
                    "m",
                    [one := sr.Body("b", mass=1, inertia=(1, 1, 1))],
                    forces=[sr.PointForce("f", one.point(0, 0, 0), (1, 0, 0), axes=np.eye(3))],
                )
            ),
            'force "f": axes must be "global" or "body", but is',
        ),
        (lambda: sr.Event("x", name="two\nlines"), "the name of an event must be a text on one line"),
        (lambda: sr.Event("x", name="\x1b[31m"), "the name of an event must be a text on one line"),
        (
            lambda: sr.Event(lambda t, q, v: t, name=np.ones(0)),
            "the name of an event must be a text on one line",
        ),
        (lambda: sr.Curve.table([(0, 0), (1, 0)], periodic=np.zeros(3)), "periodic must be True or False"),
        (lambda: sr.parse_expression("x", sr.ground), "variables must be a list of names"),
        (lambda: sr.Point(sr.ground, (0, 0, 0), "globl"), 'axes must be "global" or "body", but is "globl"'),
        (lambda: sr.Point(sr.ground, (0, 0, 0), np.zeros(3)), 'axes must be "global" or "body", but is'),
        (
            lambda: sr.Revolute("p", np.zeros(3), None, (0, 0, 0), (0, 0, 1)),
            "one of its two bodies is missing",
        ),
        (
            lambda: sr.linearize(system(), system().q0, coordinates=np.zeros((2, 2))),
            "coordinates must be a list of names",
        ),
        (lambda: sr.parse_expression("x", np.array(1.0)), "variables must be a list of names"),
        (
            lambda: sr.linearize(system(), system().q0, coordinates=["pin.angle", ["x"]]),
            "coordinates must be a list of names",
        ),
        (lambda: sr.load_urdf("none.urdf", search=np.array(np.nan)), "search must be a list of folders"),
    ],
)
def test_arguments_of_wrong_kinds(call: Callable[[], Any], message: str) -> None:
    with pytest.raises((TypeError, ValueError), match=message):
        call()


def test_a_first_step_that_is_longer_than_the_run() -> None:
    runs = [sr.simulate(system(), until=0.1, method=sr.Radau(first_step=first)) for first in (0.1, 1e300)]
    assert runs[0].success
    assert np.array_equal(runs[0].q, runs[1].q)


def test_an_archive_is_refused(tmp_path: Path) -> None:
    archive, package = tmp_path / "sarrus.zip", Path(sr.__file__).parent
    with zipfile.ZipFile(archive, "w") as made:
        for name in ("__init__", "exports", "deferred"):
            made.write(package / f"{name}.py", f"sarrus/{name}.py")
    code = f"import sys; sys.path.insert(0, {str(archive)!r}); import sarrus"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "ImportError" in done.stderr
    assert "cannot be imported from an archive. Install or unpack it" in done.stderr


def test_tables_for_spreadsheets_have_no_formulas_and_lines_of_their_own(tmp_path: Path) -> None:
    from sarrus.results.motion.tables import quoted
    from sarrus.results.saving.exported_file import write_table

    names = ["=1+1", "+x", "-x", "@x", "a\nb", "\x1b[31m", 'a "b", c', "slider.x [m]"]
    expected = ["'=1+1", "'+x", "'-x", "'@x", "a\\nb", "\\x1b[31m", 'a "b", c', "slider.x [m]"]
    write_table(tmp_path / "a.csv", names, [[1.0] * len(names)])
    import csv

    with (tmp_path / "a.csv").open(newline="") as file:
        assert next(csv.reader(file)) == expected
    assert next(csv.reader([",".join(map(quoted, names))])) == expected
