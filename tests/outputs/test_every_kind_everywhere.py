"""Outputs of every kind of part have the same value, unit and label in all places that take names."""

from __future__ import annotations

import base64
import contextlib
import csv
import gzip
import io
import json
import re
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from tests.outputs.every_kind import POINT, UNTIL, outputs, parts, run, system

import sarrus as sr
from sarrus.analyses.dynamics.events.event_output import EventOutput
from sarrus.cli import main
from sarrus.model import Driver, Force, Joint
from sarrus.outputs import Level, Output, outputs_of
from sarrus.studies.responses import responses_of
from sarrus.studies.runs import Simulation, lookup_of

pytestmark = pytest.mark.slow  # kernels of every kind of part

Found = Mapping[str, tuple[Any, str, str]]  # values or the last one, unit, label; "" where a place has none


@cache
def columns() -> dict[str, np.ndarray]:
    """The values over time, all read together."""
    frame = run().to_frame(*outputs())
    return dict(zip(outputs(), frame.to_numpy().T, strict=True))


def test_the_model_has_every_kind() -> None:
    every = {kind for base in (Joint, Driver, Force) for kind in base.kinds.values()}
    assert {kind for kind in every if kind.__module__.startswith("sarrus.")} == {*map(type, parts().values())}
    assert all(np.all(np.isfinite(values)) for values in columns().values())
    assert {one.unit for one in outputs().values() if ".multiplier." not in one.name} == {
        "", "1", "1/m", "1/s", "A", "A/s", "J", "V", "N", "N m", "N/s", "N/m²", "W",
        "m³/s", "m", "m/s", "m/s²", "rad", "rad/s", "rad/s²", "s",
    }  # fmt: skip


def of_run(_: Path) -> Found:
    found = (run().output(name) for name in outputs())
    return {one.name: (one.values, one.unit, one.label) for one in found}


def of_attributes(_: Path) -> Found:
    """``run["spring"].tension`` and ``run["pin"].force[:, 0]``; of several elements of a part, their sum."""
    found = {}
    for name, one in outputs().items():
        part, _, rest = (name.replace(POINT, "p") if name.startswith(POINT) else name).partition(".")
        motion = run()[POINT if part == "p" else part]
        words = rest.split(".")
        at = {"x": 0, "y": 1, "z": 2}.get(words[-1], int(words[-1]) - 1 if words[-1].isdigit() else None)
        if not_attributes(one):
            continue
        own = "_".join(words if at is None else words[:-1]) or "position"
        values = getattr(motion, own)
        found[name] = (values if values.ndim == 1 else values[:, at], motion.units[own], one.label)
    return found


@cache
def names_of_all() -> set[str]:
    return {one.name for one in outputs_of(system())}


def not_attributes(one: Output) -> bool:
    """The arrays of bodies have names of their own, states are outputs; of `stay.power.1` and its like the sum is.

    The attribute of `coil.torque` and `coil.torque.x` is the scalar.
    """
    part, whole, known = one.name.partition(".")[0], one.name.rpartition(".")[0], names_of_all()
    return part in system().bodies or part in outputs() or whole in known


def of_plot(_: Path) -> Found:
    """Lines by their labels; the unit is on the axis."""
    axes = np.ravel(run().plot(*outputs(), ax=Figure()))
    found = {}
    for ax in axes:
        unit = re.fullmatch(r"(?s).*?\[(.*)\]|(.*)", ax.get_ylabel())[1] or ""
        found |= {str(line.get_label()): (line.get_ydata(), unit, "") for line in ax.lines}
    return found


def of_csv(folder: Path) -> Found:
    run().to_csv(folder / "run.csv", *outputs())
    header, *rows = csv.reader((folder / "run.csv").read_text(encoding="utf-8").splitlines())
    values = np.array(rows, dtype=float).T
    return {
        name: (x, "", label) for name, x, label in zip(time_first(), values, ["", *header[1:]], strict=True)
    }


def time_first() -> list[str]:
    """The columns of a table, which has the time once."""
    return ["t", *(name for name in outputs() if name != "t")]


def of_frame(_: Path) -> Found:
    frame = run().to_frame(*outputs())
    units = frame.attrs["units"]
    return {
        name: (frame[one.label].to_numpy(), units[one.label], one.label) for name, one in outputs().items()
    }


def of_xarray(_: Path) -> Found:
    data = run().to_xarray(*outputs())
    assert data["t"].dims == ("t",)
    return {name: (data[name].to_numpy(), data[name].attrs["units"], "") for name in outputs()}


def of_responses(_: Path) -> Found:
    found = sr.sensitivity(run(), [sr.Final(name) for name in outputs()], ["gravity.z"])
    return {name: (found.values[n : n + 1], found.response_units[n], "") for n, name in enumerate(outputs())}


def of_studies(_: Path) -> Found:
    names = list(outputs())
    found = responses_of([f"final({name})" for name in names])
    simulation, lookup = Simulation(until=UNTIL), lookup_of(system(), run())
    simulation.check(system(), found, ())
    return {name: (one.value(run(), run().t, lookup), "", "") for name, one in zip(names, found, strict=True)}


def of_events(_: Path) -> Found:
    """Events see single states."""
    known = [name for name, one in outputs().items() if one.level < Level.HISTORY]
    last = float(run().t[-1]), run().q[-1], run().v[-1]
    return {name: (EventOutput(system(), name)(*last), "", "") for name in known}


def of_page(folder: Path) -> Found:
    """Curves in the page for the browser, whose numbers have single precision."""
    page = run().animate(folder / "page.html", outputs=[*outputs()], count=5).read_text(encoding="utf-8")
    scene = json.loads(re.search(r'id="scene"[^>]*>(.*?)</script>', page, re.S)[1])
    packed = re.search(r'id="numbers"[^>]*>(.*?)</script>', page, re.S)[1]
    block = gzip.decompress(base64.b64decode(packed))
    curves = scene["runs"][0]["curves"]
    return {
        one["name"]: (np.frombuffer(block, "<f4", one["values"][1], one["values"][0]), one["unit"], "")
        for one in curves
    }


def of_shell(folder: Path) -> Found:
    """``sarrus run --csv`` of a model file."""
    path = folder / "m.yaml"
    system().model.save(path)
    line = ["run", str(path), "--until", str(UNTIL), "--steps", "4", "--rtol", "1e-10", "--atol", "1e-12"]
    assert main([*line, "--csv", str(folder / "shell.csv"), "--columns", *outputs()]) == 0
    header, *_, last = csv.reader((folder / "shell.csv").read_text(encoding="utf-8").splitlines())
    return {
        name: (float(x), "", label)
        for name, x, label in zip(time_first(), last, ["", *header[1:]], strict=True)
    }


def of_shell_responses(folder: Path) -> Found:
    """``sarrus sensitivity --response`` with names of outputs alone, which are their final values."""
    path, answer = folder / "m.yaml", io.StringIO()
    system().model.save(path)
    line = ["sensitivity", str(path), "--until", str(UNTIL), "--rtol", "1e-10", "--atol", "1e-12", "--json"]
    with contextlib.redirect_stdout(answer):
        assert main([*line, "--wrt", "gravity.z", "--response", *outputs()]) == 0
    found = json.loads(answer.getvalue())["responses"].values()
    pairs = zip(outputs(), found, strict=True)
    return {name: (one["value"], one["unit"], "") for name, one in pairs}


PLACES: dict[str, Callable[[Path], Found]] = {
    name.removeprefix("of_"): place for name, place in tuple(globals().items()) if name.startswith("of_")
}
LOOSE = {"page": 1e-6, "shell": 1e-6, "shell_responses": 1e-6, "responses": 1e-9, "events": 1e-8}
MISSING = {"attributes": not_attributes, "events": lambda one: one.level == Level.HISTORY}


@pytest.mark.filterwarnings("ignore:.*assembly changed")
@pytest.mark.one_in(8)
@pytest.mark.parametrize("place", PLACES)
def test_values_units_and_labels_are_the_same(place: str, tmp_path: Path) -> None:
    found, limit, wrong = PLACES[place](tmp_path), LOOSE.get(place, 1e-12), dict[str, Any]()
    left_out: Callable[[Output], bool] = MISSING.get(place, lambda one: False)
    assert {n for n in outputs() if n not in found} == {n for n, one in outputs().items() if left_out(one)}
    for name, (values, unit, label) in found.items():
        one, wanted = outputs()[name], columns()[name]
        scale = max(abs(wanted).max(), 1.0)
        if not np.allclose(values, wanted if np.size(values) > 1 else wanted[-1], rtol=0, atol=limit * scale):
            wrong[name] = np.ravel(values)[-1], wanted[-1]
        if unit not in ("", one.unit) or label not in ("", one.label):
            wrong[name] = unit, label
    assert not wrong


def test_completion_and_messages_know_them() -> None:
    keys, wrong = set(run()._ipython_key_completions_()), list[str]()
    for name in outputs():
        part, _, word = name.removeprefix(POINT).partition(".")
        near = f"{name[:-1]}q{name[-1]}" if name != "t" else "tt"
        with pytest.raises(sr.SarrusError, match="has no output") as error:
            run().output(near)
        if f'"{name}"' not in str(error.value) or (part and part not in keys):
            wrong.append(f"{near}: {error.value}")
    assert not wrong
