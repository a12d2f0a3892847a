"""A file's ending says who reads it; the command line takes them all."""

from __future__ import annotations

import inspect
import sys
from pathlib import Path

import pytest

import sarrus as sr
from sarrus import mechanisms
from sarrus.cli import main

PANDA = Path(__file__).parent / "data" / "panda.urdf"


def test_a_model_file_is_read_as_ever() -> None:
    assert sr.load_any(mechanisms.path("slider_crank")).name == sr.load(mechanisms.path("slider_crank")).name


def test_an_xml_that_begins_as_a_robot_is_a_urdf(tmp_path: Path) -> None:
    path = tmp_path / "panda.xml"
    path.write_bytes(PANDA.read_bytes())
    assert sr.load_any(path, mimic="free").name == "panda"


def test_a_wish_that_a_reader_does_not_have_is_refused(tmp_path: Path) -> None:
    with pytest.raises(sr.ModelError, match="without the option base"):
        sr.load_any(mechanisms.path("slider_crank"), base="floating")
    with pytest.raises(sr.ModelError, match="without the option bases"):
        sr.load_any(tmp_path / "model.xml", bases="floating")


def test_load_reads_all_formats_and_shipped_models(tmp_path: Path) -> None:
    assert sr.load(PANDA, mimic="lock").name == "panda"
    assert sr.load_any("slider_crank", parameters={}).name == "slider-crank"
    with pytest.raises(sr.ModelError, match="without the option base"):
        sr.load("slider_crank", base="fixed")
    with pytest.raises(sr.ModelError, match="without the option parameters"):
        sr.load(PANDA, parameters={"a": 1})


def test_import_options_are_those_of_all_formats() -> None:
    common = {"base", "q0", "loops", "lock", "mimic", "inertia", "keep_fixed", "ignore", "meshes", "search"}
    for load in (sr.load_urdf, sr.load_sdf, sr.load_mjcf):
        assert common <= {*inspect.signature(load).parameters}


INNER = '<body name="b"><joint name="j"/><geom size="1"/></body>'
FREE = f'<body name="a" pos="1 2 3">{{joint}}<geom size="1"/>{INNER}</body>'
BASES = [("<freejoint/>", "fixed", 1), ("", "floating", 2), ("", "file", 1)]


@pytest.mark.parametrize(("joint", "base", "bodies"), BASES)
@pytest.mark.needs("mujoco")
def test_the_base_of_an_mjcf(joint: str, base: str, bodies: int, tmp_path: Path) -> None:
    path = tmp_path / "model.mjcf"
    path.write_text(f"<mujoco><worldbody>{FREE.format(joint=joint)}</worldbody></mujoco>")
    robot = sr.load(path, base=base)
    assert len(robot.bodies) == bodies
    assert [*robot.link("a").pose().r] == [1, 2, 3]


def test_an_unknown_ending_is_refused(tmp_path: Path) -> None:
    with pytest.raises(sr.ModelError, match="must end in"):
        sr.load_any(tmp_path / "model.step")


def test_without_mujoco_one_sentence_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "model.xml"
    path.write_text("<mujoco/>")
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ImportError, match=r"pip install .*sarrus\[mjcf\]"):
        sr.load_mjcf(path)


@pytest.mark.slow
def test_the_command_line_runs_a_urdf(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(PANDA), "--mimic", "lock", "--until", "0.01", "--steps", "2"]) == 0
    assert "panda_link7" in capsys.readouterr().out


def test_the_command_line_says_why_it_does_not(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "panda.urdf"
    path.write_text(PANDA.read_text().replace('<mimic joint="panda_finger_joint1"', '<mimic joint="finger"'))
    assert main(["run", str(path)]) == 2
    told = capsys.readouterr().err
    assert told.startswith(f"sarrus: {path}:342: ")
    assert '<mimic> names "finger"' in told
