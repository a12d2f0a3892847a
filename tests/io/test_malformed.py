"""A wrong URDF is refused by one message: file, line, part, what is wrong, remedy."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import pytest

import sarrus as sr

ROBOT = """\
<robot name="arm">
  <link name="base"/>
  <link name="upper">
    <inertial>
      <origin xyz="0 0 0.5" rpy="0 0 0"/>
      <mass value="2"/>
      <inertia ixx="0.2" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.1"/>
    </inertial>
  </link>
  <link name="lower">
    <inertial><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/> <child link="upper"/>
    <axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="9" velocity="3"/>
  </joint>
  <joint name="elbow" type="continuous">
    <origin xyz="0 0 1" rpy="0 0 0"/>
    <parent link="upper"/> <child link="lower"/>
    <axis xyz="0 1 0"/>
  </joint>
</robot>
"""


class Wrong(NamedTuple):
    """One change of the file, and what must be said: line, then words."""

    old: str
    new: str
    line: int
    words: tuple[str, ...]


BACK = '<joint name="back" type="fixed"><parent link="lower"/><child link="base"/></joint></robot>'
LOWER = '<parent link="upper"/> <child link="lower"/>'
TWICE = '<mass value="1"/><mass value="1"/>'
DOCTYPE = '<!DOCTYPE robot [<!ENTITY a "x"><!ENTITY b "&a;&a;">]>\n<robot name="arm">'
MIMIC = '<axis xyz="0 1 0"/><mimic joint="shulder"/>\n  </joint>\n</robot>'

WRONG = {
    "no end": Wrong("</robot>", "", 24, ("not well-formed", "Fix it")),
    "mismatch": Wrong(
        '</link>\n  <link name="lower"', '</lnk>\n  <link name="lower"', 9, ("mismatched tag",)
    ),
    "entities": Wrong('<robot name="arm">', DOCTYPE, 1, ("document type", "Remove")),
    "xacro": Wrong('<link name="base"/>', "<xacro:arm/>", 2, ("macro", "Expand")),
    "deep": Wrong('<link name="base"/>', "<a>" * 70 + "</a>" * 70, 2, ("deeper than 64",)),
    "other root": Wrong('<robot name="arm">', "<sdf>", 1, ("<sdf>", "Give a URDF")),
    "link without name": Wrong('<link name="base"/>', "<link/>", 2, ("<link> has no name", "Add it")),
    "link twice": Wrong('<link name="lower">', '<link name="upper">', 10, ("twice", "line 3", "Rename")),
    "joint twice": Wrong('name="elbow"', 'name="shoulder"', 18, ("twice", "line 13")),
    "unknown type": Wrong('"continuous"', '"continous"', 18, ("elbow", "unknown type", "Did you mean")),
    "no type": Wrong(' type="continuous"', "", 18, ("<joint> has no type",)),
    "no parent": Wrong('<parent link="upper"/>', "", 18, ("elbow", "no <parent>", "Add it")),
    "unknown link": Wrong(
        '<parent link="upper"/>', '<parent link="uper"/>', 18, ("elbow", "no link", "Did you mean")
    ),
    "itself": Wrong('<parent link="upper"/>', '<parent link="lower"/>', 18, ("itself", "two different")),
    "two parents": Wrong(
        LOWER,
        LOWER.replace("upper", "base").replace("lower", "upper"),
        18,
        ("already the child", "loops file"),
    ),
    "circle": Wrong('<parent link="base"/>', '<parent link="lower"/>', 13, ("reach the root", "circle")),
    "no root": Wrong("</robot>", BACK, 1, ("none is the root",)),
    "two roots": Wrong(
        '<link name="base"/>', '<link name="base"/><link name="free"/>', 2, ("both are no child",)
    ),
    "no number": Wrong('<mass value="2"/>', '<mass value="2kg"/>', 6, ("upper", "must be a number", "2kg")),
    "underscore": Wrong('<mass value="2"/>', '<mass value="1_0"/>', 6, ("must be a number",)),
    "nan": Wrong('<mass value="2"/>', '<mass value="nan"/>', 6, ("finite",)),
    "too few": Wrong('xyz="0 0 0.5"', 'xyz="0 0.5"', 5, ("<origin> xyz", "3 numbers")),
    "infinite": Wrong('xyz="0 0 0.5"', 'xyz="0 0 inf"', 5, ("finite",)),
    "zero axis": Wrong(
        '<axis xyz="0 1 0"/>\n    <limit', '<axis xyz="0 0 0"/>\n    <limit', 15, ("zero length",)
    ),
    "negative mass": Wrong('<mass value="2"/>', '<mass value="-2"/>', 6, ("negative", "-2")),
    "no mass": Wrong('<mass value="2"/>', "", 4, ("no <mass>", "Add it")),
    "mass twice": Wrong('<mass value="1"/>', TWICE, 11, ("twice", "Remove")),
    "no izz": Wrong(' izz="0.1"/>\n    </inertial>', "/>\n    </inertial>", 7, ("no izz", "Add it")),
    "misspelt attribute": Wrong(
        '<mass value="2"/>', '<mass vlaue="2"/>', 6, ("vlaue", "Did you mean", "value")
    ),
    "misspelt element": Wrong("<limit lower", "<limits lower", 16, ("limits", "Did you mean")),
    "flat inertia": Wrong(
        'izz="0.1"/>\n', 'izz="0"/>\n', 3, ("upper", "positive definite", 'inertia="given"')
    ),
    "triangle": Wrong('izz="0.1"/>\n', 'izz="0.9"/>\n', 3, ("triangle", 'inertia="given"')),
    "mimics nobody": Wrong(
        '<axis xyz="0 1 0"/>\n  </joint>\n</robot>', MIMIC, 18, ("shulder", "Did you mean")
    ),
    "mimics itself": Wrong(
        '<axis xyz="0 1 0"/>\n  </joint>\n</robot>',
        MIMIC.replace("shulder", "elbow"),
        18,
        ("back to it", "follow none"),
    ),
}


def refused(path: Path, **wishes: object) -> str:
    with pytest.raises(sr.ModelError) as error:
        sr.load_urdf(path, **wishes)  # type: ignore[arg-type]
    told = str(error.value)
    assert "\n" not in told
    return told


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_file_is_refused(name: str, tmp_path: Path) -> None:
    wrong = WRONG[name]
    assert wrong.old in ROBOT
    path = tmp_path / "arm.urdf"
    text = ROBOT.replace(wrong.old, wrong.new, 1)
    path.write_text(text.replace("</robot>", "</sdf>") if name == "other root" else text)
    told = refused(path)
    assert told.startswith(f"{path}:{wrong.line}: "), told
    for word in wrong.words:
        assert word in told, told


def test_the_right_file_is_read(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(ROBOT)
    assert [body.name for body in sr.load_urdf(path).bodies] == ["upper", "lower"]


CONTENTS = {
    "empty": (b"", "is empty"),
    "blank": (b"  \n", "is empty"),
    "binary": (b"\x00\x01", "not well-formed"),
    "text": (b"hello", "not well-formed"),
    "two roots": (b"<robot/><robot/>", "not well-formed"),
    "encoding": (b'<?xml version="1.0" encoding="nonsense"?><robot/>', "encoding"),
    "no links": (b"<robot/>", "has no links"),
    "only ground": (b'<robot name="r"><link name="a"/></robot>', "nothing in it moves"),
}


@pytest.mark.parametrize("name", CONTENTS)
def test_what_is_no_robot_is_refused(name: str, tmp_path: Path) -> None:
    content, words = CONTENTS[name]
    path = tmp_path / "arm.urdf"
    path.write_bytes(content)
    assert words in refused(path)


def test_a_bomb_of_entities_is_refused_at_once(tmp_path: Path) -> None:
    lines = "".join(f'<!ENTITY a{n} "{f"&a{n - 1};" * 10}">' for n in range(1, 12))
    path = tmp_path / "bomb.urdf"
    path.write_text(f'<!DOCTYPE robot [<!ENTITY a0 "ha">{lines}]><robot name="&a11;"/>')
    assert "document type" in refused(path)


WISHES = {
    "base": ({"base": "flying"}, "base must be one of file, fixed, floating"),
    "mimic": ({"mimic": "refuse"}, "mimic must be one of"),
    "unknown joint": ({"q0": {"elbo": 1.0}}, 'Did you mean "elbow"'),
    "no number": ({"q0": {"elbow": "1"}}, "must be a number"),
    "base without base": ({"q0": {"base": [0] * 7}}, "no joint that moves"),
    "six numbers": ({"base": "floating", "q0": {"base": [0] * 6}}, "7"),
    "no turn": ({"base": "floating", "q0": {"base": [0] * 7}}, "zero length"),
    "lock": ({"lock": ["elbo"]}, 'Did you mean "elbow"'),
    "gravity": ({"gravity": (0, 9)}, "gravity"),
    "loops": ({"loops": "nowhere.yaml"}, "does not exist"),
}


@pytest.mark.parametrize("name", WISHES)
def test_a_wrong_wish_is_refused(name: str, tmp_path: Path) -> None:
    wishes, words = WISHES[name]
    path = tmp_path / "arm.urdf"
    path.write_text(ROBOT)
    assert words in refused(path, **wishes)


def test_a_missing_file_or_folder_is_refused(tmp_path: Path) -> None:
    assert "does not exist" in refused(tmp_path / "no.urdf")
    assert "is a directory" in refused(tmp_path)
