"""Hints name what was meant: by meaning, without regard to capitals, and with the reader that a file needs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import sarrus as sr
from sarrus.model.checks.other_programs import INSTEAD
from sarrus.model.drivers import Driver
from sarrus.model.file.validation_messages import MEANT
from sarrus.model.forces import Force
from sarrus.model.joints import Joint
from sarrus.model.show import suggest

HEAD = "name: a\nbodies:\n  b: {mass: 1, inertia: [1, 1, 1]}\n"


@pytest.mark.parametrize(
    ("section", "given", "meant"),
    [
        ("forces", "Damper", '"tsda" or "rsda"'),
        ("joints", "pivot", '"revolute"'),
        ("joints", "slider", '"translational"'),
        ("joints", "socket", '"spherical"'),
        ("drivers", "motor", '"angle"'),
        ("joints", "Revolute", '"revolute"'),
    ],
)
def test_types_by_other_names(section: str, given: str, meant: str, tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(f"{HEAD}{section}:\n  x: {{type: {given}}}\n")
    with pytest.raises(sr.ModelError, match=rf"unknown type .*. Did you mean {meant}\?"):
        sr.load(tmp_path / "a.yaml")


def test_what_is_meant_exists() -> None:
    kinds = {*Joint.kinds, *Force.kinds, *Driver.kinds}
    assert {kind for meant in MEANT.values() for kind in meant} <= kinds
    assert not kinds & MEANT.keys()


def test_capitals_do_not_count() -> None:
    assert suggest("crank.X", ["crank.z", "crank.x"]) == 'Did you mean "crank.x"?'
    assert suggest("q7", [f"p{k}" for k in range(5000)]).startswith("Choose from p0")


def test_shipped_mechanisms_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert len(sr.load("slider_crank").bodies) == len(sr.load_any("slider_crank").bodies) > 0
    monkeypatch.chdir(tmp_path)
    with pytest.raises(sr.ModelError, match="does not exist"):
        sr.load("slider_crunk.yaml")


def test_a_body_is_no_coordinate() -> None:
    system = sr.System(sr.load("slider_crank"))
    with pytest.raises(KeyError, match=r"slider-crank has no output 'crank'\. Choose from crank\."):
        sr.assemble(system, rates={"crank": 1.0})


@pytest.mark.needs("mujoco")
def test_an_mjcf_where_nothing_moves(tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_text('<mujoco><worldbody><geom size="1"/></worldbody></mujoco>')
    with pytest.raises(sr.ModelError, match=r"nothing in it moves. Give a body a joint that moves"):
        sr.load_mjcf(tmp_path / "a.xml")


def test_names_of_other_programs_say_what_takes_their_place() -> None:
    for text in INSTEAD.values():
        for name in re.findall(r"sr\.(\w+)", text):
            assert hasattr(sr, name), f"{name}, of which a message speaks, does not exist"
    for names in INSTEAD:
        for name in names.split():
            if name in sr.__all__:
                continue  # it is the name of a part by now
            with pytest.raises(AttributeError, match=r"Use .+\."):
                getattr(sr, name)
    with pytest.raises(AttributeError, match=r"Did you mean \"Revolute\""):
        sr.Revolut  # noqa: B018
