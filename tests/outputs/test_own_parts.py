"""The outputs of a user's joint, driver and force work in every place that takes names."""

from __future__ import annotations

import csv
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from tests.outputs.own_parts import FILE, KINDS, NAMES, PLACE, UNITS, VALUES, Attractor, described
from tests.views.page_parts import read

import sarrus as sr
from sarrus.cli import main
from sarrus.model.written import with_numbers
from sarrus.outputs.measure import measured

SETTINGS = {"until": 0.4, "method": sr.Radau(rtol=1e-9, atol=1e-11)}
WRT = ["magnet.strength", "bowl.k", "bead.mass"]


@cache
def run() -> sr.Trajectory:
    return sr.simulate(sr.System(described()), t_eval=np.linspace(0, 0.4, 21), store="steps", **SETTINGS)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", NAMES)
def test_values_units_and_labels_agree(name: str, tmp_path: Path) -> None:
    found, wanted = run().output(name), VALUES(run())[name]
    label = f"{name} [{UNITS[name]}]" if UNITS[name] else name
    assert found.values == pytest.approx(wanted, rel=1e-10, abs=1e-12)
    assert (found.unit, found.label) == (UNITS[name], label)
    axes = run().plot(name, ax=Figure().subplots())
    assert axes.lines[0].get_ydata() == pytest.approx(wanted, rel=1e-10, abs=1e-12)
    assert axes.get_ylabel() == label
    run().to_csv(tmp_path / "run.csv", name)
    head, *rows = csv.reader((tmp_path / "run.csv").read_text().splitlines())
    assert head == ["t [s]", label]
    assert [float(row[1]) for row in rows] == pytest.approx(wanted, rel=1e-10, abs=1e-12)
    assert run().to_frame(name)[label].to_numpy() == pytest.approx(wanted, rel=1e-10, abs=1e-12)
    parts = read(run().animate(tmp_path / "run.html", outputs=[name], count=21))
    (curve,) = parts.told["runs"][0]["curves"]
    assert curve["unit"] == UNITS[name]
    assert parts.array(curve["values"], 1)[:, 0] == pytest.approx(wanted, rel=1e-5, abs=1e-5)


@pytest.mark.slow
def test_gradients_are_those_of_changed_models() -> None:
    responses = [*(sr.Final(name) for name in NAMES), *(sr.Integral(name) for name in NAMES)]
    back, forward = (sr.sensitivity(run(), responses, WRT, method=way) for way in ("adjoint", "direct"))
    assert np.allclose(back.matrix, forward.matrix, rtol=1e-9, atol=1e-11)
    assert back.values[: len(NAMES)] == pytest.approx([VALUES(run())[name][-1] for name in NAMES], rel=1e-9)
    over_time = sr.state_derivatives(run(), WRT)
    assert np.array([over_time.output(name)[-1] for name in NAMES]) == pytest.approx(
        back.matrix[: len(NAMES)], rel=1e-8, abs=1e-9
    )
    for k, (parameter, base) in enumerate(zip(WRT, back.at, strict=True)):
        h, ends = 1e-4 * base, []
        for sign in (1, -1):
            moved = sr.System(with_numbers(described(), {parameter: base + sign * h}))
            other = sr.simulate(moved, store="steps", **SETTINGS)
            ends.append(sr.sensitivity(other, responses, ["bead.mass"]).values)
        difference = (ends[0] - ends[1]) / (2 * h)
        assert back.matrix[:, k] == pytest.approx(difference, rel=1e-5, abs=1e-6), parameter


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_events_are_found_and_their_times_differentiated(name: str) -> None:
    values = run().output(name).values
    level = float(values[12] + values[13]) / 2
    event = sr.Event(f"{name} - {level!r}", terminal=True, name="here")
    ended = sr.simulate(sr.System(described()), events=event, store="steps", **SETTINGS)
    assert ended.status == "event"
    found = sr.sensitivity(ended, [sr.AtEvent("t", event="here"), sr.Final(name)], WRT)
    assert found.values[1] == pytest.approx(level, rel=1e-9, abs=1e-12)
    assert abs(found.matrix[1]).max() < 1e-7 * (1 + abs(level)) * (1 + abs(found.matrix[0]).max())


@pytest.mark.slow
def test_a_study_evaluates_them() -> None:
    answers = {name.replace(".", "_"): f"final({name})" for name in NAMES}
    table = sr.study(
        described(), {"magnet.strength": [3.0]}, answers, analysis=sr.Simulation(until=0.4), workers=1
    )
    assert table.success.all()
    plain = sr.simulate(sr.System(described()), until=0.4)
    for name in NAMES:
        wanted = VALUES(plain)[name][-1]
        assert table.case(0)[name.replace(".", "_")] == pytest.approx(wanted, rel=1e-6, abs=1e-7), name


@pytest.mark.slow
def test_the_shell_takes_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for kind, own in KINDS.items():
        for name, one in own.items():
            monkeypatch.setitem(kind.kinds, name, one)
    path = tmp_path / "bead.yaml"
    path.write_text(FILE)
    begin = ["run", str(path), "--until", "0.4", "--steps", "20"]
    files = ["--csv", str(tmp_path / "run.csv"), "--figure", str(tmp_path / "run.svg")]
    assert main([*begin, *files, "--columns", *NAMES, "--plot", *NAMES]) == 0
    head, *_, last = csv.reader((tmp_path / "run.csv").read_text().splitlines())
    assert head[1:] == [run().output(name).label for name in NAMES]
    wanted = [VALUES(run())[name][-1] for name in NAMES]
    assert [float(x) for x in last[1:]] == pytest.approx(wanted, rel=1e-4, abs=1e-5)
    page = ["view", str(path), "--until", "0.1", "--output", str(tmp_path / "bead.html")]
    assert main([*page, "--plot", "bowl.normal.x", "push.target"]) == 0
    capsys.readouterr()
    responses = [f"final({name})" for name in NAMES]
    asked = ["--response", *responses, "--wrt", "magnet.strength"]
    assert main(["sensitivity", str(path), "--until", "0.4", *asked]) == 0
    assert "bowl.steepness" in capsys.readouterr().out
    assert main([*begin, "--columns", "bowl.steepnes"]) == 2
    assert 'Did you mean "bowl.steepness"?' in capsys.readouterr().err


def test_functions_of_the_position_have_gradients() -> None:
    system = run().system
    for name in ("bowl.steepness", "bowl.normal.x", "magnet.distance"):
        rate = run().output(name, rate=True).values[-1]
        assert measured(system, name, "a test").rate(run().q[-1], run().v[-1]) == pytest.approx(
            rate, rel=1e-12
        )
    for name, wrong in (
        ("push.target", "takes coordinates of bodies"),
        ("bowl.speed", "depends on velocities"),
    ):
        with pytest.raises(sr.SarrusError, match=wrong):
            sr.workspace_range(system, name)


def test_a_workspace_is_of_a_users_output() -> None:
    """A bead on a line at a distance of sqrt(5) from a place, which is the nearest at y = 1."""
    bead = sr.Body("bead", mass=2.0, inertia=(1, 1, 1))
    guide = sr.Translational("guide", sr.ground, bead, point=(0, 0, 0), axis=(0, 1, 0))
    model = sr.Model("bead on a line", [bead], [guide], forces=[Attractor("magnet", bead, PLACE, 3.0)])
    found = sr.workspace_range(sr.System(model), "magnet.distance", limits={"guide": (-1.0, 2.0)})
    assert found.success
    (interval,) = found.intervals
    assert interval == pytest.approx((np.sqrt(5), 3.0), rel=1e-9)
