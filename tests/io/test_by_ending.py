"""The ending and the content of a file determine its reader; the command line reads all formats."""

from __future__ import annotations

import gzip
import inspect
import re
import sys
from pathlib import Path

import pytest
from tests.model.test_malformed import check_message

import sarrus as sr
from sarrus import mechanisms
from sarrus.cli import main
from sarrus.io.robot.options import IGNORABLE

PANDA = Path(__file__).parent / "data" / "panda.urdf"


def test_a_model_file_is_read_as_ever() -> None:
    assert sr.load_any(mechanisms.path("slider_crank")).name == sr.load(mechanisms.path("slider_crank")).name


def test_an_xml_that_begins_as_a_robot_is_a_urdf(tmp_path: Path) -> None:
    path = tmp_path / "panda.xml"
    path.write_bytes(PANDA.read_bytes())
    assert sr.load_any(path, mimic="free").name == "panda"


URDF = (
    '<?xml version="1.0"?>\n<!-- <mujoco> is in a comment -->\n<robot name="a"><link name="base"/>'
    '<link name="arm"><inertial><mass value="1"/>'
    '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
    '<joint name="j" type="continuous"><parent link="base"/><child link="arm"/></joint></robot>'
)
SDF = '<sdf version="1.7"><model name="a"><link name="arm"/></model></sdf>'
MJCF = (
    '<mujoco model="a"><worldbody><body name="arm"><freejoint/><geom size="1"/></body></worldbody></mujoco>'
)
YAML = "name: a\nbodies: {arm: {mass: 1, inertia: [1, 1, 1]}}\n"
JSON = '{"name": "a", "bodies": {"arm": {"mass": 1, "inertia": [1, 1, 1]}}}'
FORMATS = {"URDF": URDF, "SDF": SDF, "MJCF": MJCF, "YAML": YAML, "JSON": JSON}
JOINT = '<joint name="j" type="revolute"><parent>world</parent><child>arm</child><axis><xyz>0 1 0</xyz></axis></joint>'
ENDINGS = ("", ".xml", ".urdf", ".sdf", ".world", ".mjcf", ".xacro", ".txt", ".yaml", ".json")


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("kind", ["URDF", "SDF", "MJCF"])
@pytest.mark.needs("mujoco")
def test_the_content_decides_in_xml(kind: str, ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"model{ending}"
    path.write_text(FORMATS[kind])
    for robot in (sr.load(path), sr.load(path, inertia="given")):
        assert (robot.name, [body.name for body in robot.bodies]) == ("a", ["arm"])


@pytest.mark.parametrize("kind", ["YAML", "JSON"])
def test_a_file_without_an_ending_is_a_model_file(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "model"
    path.write_text(FORMATS[kind])
    assert sr.load(path).name == "a"


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.needs("mujoco")
def test_byte_order_marks_and_line_ends_of_windows_are_read(kind: str, tmp_path: Path) -> None:
    path = tmp_path / ("model.xml" if kind in ("URDF", "SDF", "MJCF") else f"model.{kind.lower()}")
    path.write_bytes(FORMATS[kind].replace("\n", "\r\n").replace("><", ">\r\n<").encode("utf-8-sig"))
    assert sr.load(path).name == "a"


UNREADABLE = {
    "compressed": (gzip.compress(b"<mujoco/>"), "is compressed by gzip. Unpack it first"),
    "empty": (b"", "is empty"),
    "blank": (b" \n", "is empty"),
    "broken": (b"<mujoco><worldbody></mujoco>", "is not well-formed XML, mismatched tag. Fix it"),
}


@pytest.mark.parametrize("name", UNREADABLE)
@pytest.mark.parametrize("ending", [".xml", ".mjcf", ".urdf", ".sdf"])
@pytest.mark.needs("mujoco")
def test_what_cannot_be_read_is_refused(name: str, ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"model{ending}"
    path.write_bytes(UNREADABLE[name][0])
    with pytest.raises(sr.ModelError, match=UNREADABLE[name][1]) as caught:
        sr.load(path)
    check_message(str(caught.value))


MISSING = {
    "slider_crnk": 'Did you mean "slider_crank", which is shipped?',
    "HMMWV.yaml": 'Did you mean "hmmwv", which is shipped?',
    "panda": "Check the path, or choose from car, double_wishbone, hmmwv, hmmwv_driving, macpherson, ",
    "robot.urd": 'Did you mean "robot.urdf"?',
    "other.urdf": "Check the path.",
    "folder": "is a directory",
}


@pytest.mark.parametrize("name", MISSING)
@pytest.mark.parametrize("options", [{}, {"base": "fixed"}])
def test_what_does_not_exist_has_a_suggestion(
    name: str, options: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robot.urdf").write_text(URDF)
    (tmp_path / "folder").mkdir()
    with pytest.raises(sr.ModelError, match=re.escape(MISSING[name])) as caught:
        sr.load(name, **options)
    check_message(str(caught.value))


@pytest.mark.parametrize("kind", ["URDF", "SDF", "MJCF"])
@pytest.mark.needs("mujoco")
def test_import_options_have_the_same_values_in_all_formats(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(FORMATS[kind])
    for base in ("file", "fixed", "floating"):
        if base != "fixed" or kind == "URDF":  # else nothing moves
            assert sr.load(path, base=base).bodies
    for meshes in ("draw", "ignore"):
        assert sr.load(path, meshes=meshes, inertia="given", search=[tmp_path], ignore=IGNORABLE).bodies
    with pytest.raises(sr.ModelError, match=r'ignore cannot have "flexs"\. Did you mean "flex"'):
        sr.load(path, ignore=["flexs"])
    with pytest.raises(
        sr.ModelError, match=r'ignore cannot have "all". Choose from actuators, .*, tendons\.$'
    ):
        sr.load(path, ignore=["all"])
    with pytest.raises(sr.ModelError, match=r"search has .*none, which is no folder"):
        sr.load(path, search=[tmp_path / "none"])
    with pytest.raises(TypeError, match="ignore must be a list of names, got the text 'flex'"):
        sr.load(path, ignore="flex")
    with pytest.raises(TypeError, match=r'search must be a list of folders.*Give \["meshes"\]'):
        sr.load(path, search="meshes")


HINGES = {"MJCF": MJCF.replace("<freejoint/>", "<joint/>"), "SDF": SDF.replace('"arm"/>', '"arm"/>' + JOINT)}


@pytest.mark.parametrize("kind", HINGES)
@pytest.mark.needs("mujoco")
def test_a_floating_base_that_nothing_has_is_refused(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(HINGES[kind])
    assert sr.load(path, base="fixed").joints
    with pytest.raises(sr.ModelError, match=r'joints connect all bodies with the world\. Choose "file"'):
        sr.load(path, base="floating")


def test_a_wish_that_a_reader_does_not_have_is_refused() -> None:
    with pytest.raises(sr.ModelError, match="without the option base"):
        sr.load_any(mechanisms.path("slider_crank"), base="floating")
    with pytest.raises(sr.ModelError, match="without the option bases"):
        sr.load_any(PANDA, bases="floating")


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
    (tmp_path / "model.step").write_text("ISO-10303-21;")
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


PLUGIN = (
    '<mujoco><extension><plugin plugin="mujoco.pid"><instance name="p"/></plugin></extension><worldbody>'
    '<body name="arm"><joint name="j"/><geom size="1"/></body></worldbody>'
    '<actuator><plugin joint="j" plugin="mujoco.pid" instance="p"/>'
    "</actuator></mujoco>"
)


@pytest.mark.needs("mujoco")
def test_the_command_line_has_the_import_options(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = tmp_path / "model.xml", tmp_path / "out.xml"
    path.write_text(PLUGIN)
    assert main(["convert", str(path), str(out)]) == 2
    assert "import it with ignore=['plugins']" in capsys.readouterr().err
    assert main(["convert", str(path), str(out), "--ignore", "plugins", "--meshes", "ignore"]) == 0
    assert main(["convert", str(out), str(out), "--ignore", "actuators", "j", "--search", str(tmp_path)]) == 0
    assert not sr.load(out).joints
    capsys.readouterr()
    assert main(["convert", str(path), str(tmp_path / "out.yaml"), "--ignore", "plugins", "motor"]) == 2
    assert 'ignore cannot have "motor" for a model file' in capsys.readouterr().err
