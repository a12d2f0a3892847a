"""Every kind of output of every built-in part is the same value, unit and label in every place that takes names."""

from __future__ import annotations

import csv
import re
import warnings
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from tests.sensitivity.zoo import zoo
from tests.views.page_parts import read

import sarrus as sr
from sarrus.analyses.dynamics.event_output import EventOutput
from sarrus.analyses.workspace.problem.measures import measures
from sarrus.outputs import Level, Output, outputs_of
from sarrus.outputs.motion import Series
from sarrus.studies.responses import responses_of
from sarrus.studies.runs import lookup_of

MANY = 12  # curves in one figure


@cache
def run() -> sr.Trajectory:
    """By a method whose nodes satisfy the constraints of velocities as samples do."""
    settings = {"method": sr.Radau(), "rtol": 1e-6, "atol": 1e-8, "store_steps": True}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sr.SarrusWarning)  # the parts are put together from random places
        return sr.simulate(zoo(), until=0.02, t_eval=np.linspace(0, 0.02, 5), **settings)


def kind_of(output: Output) -> tuple[str, ...]:
    """What distinguishes kinds: the class of the part, and the words behind its name; numbers count as one."""
    part, _, words = output.name.partition(".")
    sections = run().system.model.sections().values()
    classes = [type(one).__name__ for section in sections for one in section if one.name == part]
    return (*classes, re.sub(r"\d+", "n", words))


@cache
def kinds() -> dict[tuple[str, ...], Output]:
    """An output of every kind, and a point's."""
    found = {kind_of(one): one for one in outputs_of(run().system)}
    point = outputs_of(run().system, "body_0(0.1, 0.2, 0)")
    return found | {("Point", one.name.partition(").")[2]): one for one in point}


@cache
def series() -> dict[str, Series]:
    return {one.name: run().output(one.name) for one in kinds().values()}


def close(found: object, name: str, tolerance: float = 1e-9) -> bool:
    wanted = series()[name].values
    size = max(1.0, float(abs(wanted).max()))
    return np.allclose(found, wanted if np.ndim(found) else wanted[-1], rtol=tolerance, atol=tolerance * size)


def test_all_parts_and_words_are_there() -> None:
    classes, words = ({kind[at] for kind in kinds()} for at in (0, -1))
    sections = run().system.model.sections().values()
    assert {type(one).__name__ for section in sections for one in section} <= classes
    assert {"tension", "torque", "angle.rate", "compression", "depth", "force.n.x", "multiplier.n"} <= words
    assert len(kinds()) > 300
    for one in kinds().values():
        values = series()[one.name].values
        assert values.shape == run().t.shape
        assert np.all(np.isfinite(values)), one.name
        assert one.unit or ".multiplier." in one.name


def test_runs_tables_and_frames(tmp_path: Path) -> None:
    names = [*series()]
    labels = [kind.label for kind in kinds().values()]
    run().to_csv(tmp_path / "run.csv", *names)
    head, *rows = csv.reader((tmp_path / "run.csv").read_text().splitlines())
    table = np.array(rows, dtype=float)
    frame = run().to_frame(*names)
    assert head == ["t", *labels] == list(frame.columns)
    for n, (name, one) in enumerate(zip(names, kinds().values(), strict=True)):
        assert (series()[name].unit, series()[name].label) == (one.unit, one.label)
        assert close(table[:, n + 1], name), name
        assert close(frame.iloc[:, n + 1].to_numpy(), name), name
        assert np.array_equal(run().coordinate(name), series()[name].values), name
        if name.partition(".")[0] in run().bodies or "." in name:
            assert np.array_equal(run()[name], series()[name].values), name


def test_plots_and_the_viewer(tmp_path: Path) -> None:
    names = [*series()]
    for first in range(0, len(names), MANY):
        axes = run().plot(*names[first : first + MANY], ax=Figure().subplots())
        for name, line in zip(names[first : first + MANY], axes.lines, strict=True):
            assert close(line.get_ydata(), name, 1e-12), name
            assert line.get_label() == name
            assert f"[{series()[name].unit}]" in axes.get_ylabel() or not series()[name].unit
    parts = read(run().animate(tmp_path / "run.html", outputs=names, count=5, reactions=False, forces=False))
    for name, curve in zip(names, parts.told["runs"][0]["curves"], strict=True):
        assert (curve["name"], curve["unit"]) == (name, series()[name].unit)
        assert close(parts.array(curve["values"], 1)[:, 0], name, 1e-5), name


def test_responses_and_derivatives_over_time() -> None:
    """The values of responses; their derivatives, which those over time end with."""
    names = [*series()]
    found = sr.sensitivity(run(), [sr.Final(name) for name in names], ["gravity.z"], method="direct")
    over_time = sr.state_derivatives(run(), ["gravity.z"])
    for name, value, (slope,) in zip(names, found.values, found.matrix, strict=True):
        assert close(value, name, 1e-7), name
        assert over_time[name, "gravity.z"][-1] == pytest.approx(slope, rel=1e-7, abs=1e-7), name


def test_studies() -> None:
    names = [*series()]
    lookup = lookup_of(run().system, run())
    for name in names:
        (response,) = responses_of(f"final({name})")
        assert close(response.value(run(), run().t, lookup), name), name


def test_events() -> None:
    """What an event sees at the end; angles are counted from the start."""
    system = run().system
    revolutions = system.joint_coordinates.along(run().t, run().q, run().v, run().revolutions)[0][-1]
    for name in series():
        event = EventOutput(system, name)
        event.near_start(revolutions, run().memory[-1])
        found = event(float(run().t[-1]), run().q[-1], run().v[-1])
        if kinds_by_name()[name].level == Level.ACCELERATION:
            assert close(found, name, 1e-6), name
        else:
            assert close(found, name), name


@cache
def kinds_by_name() -> dict[str, Output]:
    return {one.name: one for one in kinds().values()}


def test_functions_of_the_position_are_accepted_where_these_are_wanted() -> None:
    """By workspaces; all others are refused by the reason."""
    model = run().system.model
    free = sr.System(
        sr.Model("free", bodies=list(model.bodies), joints=list(model.joints), forces=list(model.forces))
    )
    refused = 0
    for name, one in kinds_by_name().items():
        if name.partition(".")[0] in {driver.name for driver in model.drivers}:
            continue
        if one.element is not None:
            (measure,) = measures(free, [name])
            assert measure.unit == one.unit, name
        else:
            refused += 1
            with pytest.raises(sr.SarrusError, match=r"depends on|no element measures"):
                measures(free, [name])
    assert refused > 100


def test_every_misspelt_name_has_a_suggestion() -> None:
    for name in series():
        wrong = name[:-1] + "§" if "." in name else name + ".§"
        with pytest.raises(KeyError, match=r"has no output .*(did you mean|choose from)"):
            run().output(wrong)
