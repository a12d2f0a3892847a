"""Nothing of an MJCF file is ignored in silence: the whole schema is decided on, refusals and notes are seen."""

from pathlib import Path

import pytest
from tests.io.mjcf_schema import items, verdict

import sarrus as sr

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.needs("mujoco")

GEOM = '<geom name="g" type="sphere" size="0.1"{geom}/>'
BODY = f'<body name="b"><joint name="j"{{joint}}/>{GEOM}<site name="s"/>{{inside}}</body>'
WORLD = f"<worldbody>{BODY}{{world}}<site name='w'/></worldbody>"
FILE = f"<mujoco><option{{option}}>{{flags}}</option>{WORLD}{{sections}}</mujoco>"
TENDON = '<tendon><spatial name="t"{given}><site site="s"/><site site="w"/></spatial></tendon>'
WRAPPED = TENDON.replace('<site site="w"/>', '<geom geom="g" sidesite="w"/><site site="w"/>')
TWO_BELOW = (
    '<body><joint/><geom size="1" contype="0" conaffinity="0"/><body><joint/><geom size="1"/></body></body>'
)
PAIR = '<contact><pair geom1="f" geom2="g" {}/></contact>'
FLOOR = '<geom type="plane" size="1 1 1"{}/>'

REFUSED = {
    "spring of a tendon that yields": (
        "tendons",
        {"sections": TENDON.format(given=' stiffness="3" springyield="0.1"')},
    ),
    "equality of a tendon": (
        "equalities",
        {"sections": WRAPPED.format(given="") + '<equality><tendon tendon1="t"/></equality>'},
    ),
    "equality of a tendon with a pulley": (
        "equalities",
        {
            "sections": TENDON.format(given="").replace('"><site', '"><pulley divisor="2"/><site')
            + '<equality><tendon tendon1="t"/></equality>'
        },
    ),
    "compensated weights by missing actuators": (
        "joints",
        {"joint": ' actuatorgravcomp="true"', "inside": '<body gravcomp="1"><geom size="0.1"/></body>'},
    ),
    "adhesion that is never zero": (
        "actuators",
        {"sections": '<actuator><adhesion body="b" ctrlrange="1 2"/></actuator>'},
    ),
    "DC motor": (
        "actuators",
        {"sections": '<actuator><dcmotor joint="j" motorconst="2" resistance="1"/></actuator>'},
    ),
    "two motors of a joint with a limited force": (
        "actuators",
        {
            "joint": ' actuatorfrcrange="-1 1"',
            "sections": '<actuator><position joint="j" kp="3"/><motor joint="j"/></actuator>',
        },
    ),
}
NOTED = {
    "limit of a ball": ("1 limit of ball joints", {"joint": ' type="ball" range="0 10"'}),
    "contact of a cylinder": (
        "1 contact with planes of shapes",
        {"world": FLOOR.format(""), "inside": '<geom type="cylinder" size="1 1"/>'},
    ),
    "torsional friction": ("1 contact with torsional", {"world": FLOOR.format(' condim="4"')}),
    "contact of two shapes": (
        " of shapes with others than planes",
        {"inside": TWO_BELOW},
    ),
    "adhesion of a pair": (
        "1 contact with torsional friction, adhesion",
        {"world": FLOOR.format(' name="f"'), "sections": PAIR.format('adhesion="3"')},
    ),
    "torsional friction of a pair": (
        "1 contact with torsional",
        {"world": FLOOR.format(' name="f"'), "sections": PAIR.format('condim="4"')},
    ),
    "two coefficients of a pair": (
        "1 contact with torsional",
        {"world": FLOOR.format(' name="f"'), "sections": PAIR.format('condim="3" friction="0.5 0.4"')},
    ),
    "sensor relative to a frame": (
        "1 sensor of other kinds",
        {
            "sections": '<sensor><framepos objtype="site" objname="s" reftype="site" refname="w"/></sensor>',
        },
    ),
    "noise": ("1 noise of sensors", {"sections": '<sensor><gyro site="s" noise="1"/></sensor>'}),
    "cutoff": ("with a cutoff", {"sections": '<sensor><gyro site="s" cutoff="1"/></sensor>'}),
    "interval": ("1 delay and interval", {"sections": '<sensor><gyro site="s" interval="0.1"/></sensor>'}),
    "sensor": ("1 touch sensor", {"sections": '<sensor><touch site="s"/></sensor>'}),
    "motor of a site": (
        "1 actuator other",
        {"inside": '<site name="r"/>', "sections": '<actuator><motor site="s" refsite="r"/></actuator>'},
    ),
    "early activation": (
        "1 setting actearly",
        {"sections": '<actuator><general joint="j" dyntype="filter" actearly="true"/></actuator>'},
    ),
    "motor with a delay": (
        "or with delays",
        {"sections": '<actuator><motor joint="j" delay="0.1" nsample="9"/></actuator>'},
    ),
    "soft equality": (
        "1 compliance of equalities",
        {"sections": '<equality><connect body1="b" body2="world" anchor="0 0 0"/></equality>'},
    ),
}
SILENT = {
    "no contact by flag": {"flags": '<flag contact="disable"/>'},
    "no contact by type": {"geom": ' contype="0"'},
    "light": {"inside": '<light pos="0 0 1"/><camera pos="0 0 1"/>', "geom": ' contype="0"'},
}


def written(folder: Path, given: dict[str, str]) -> Path:
    path = folder / "model.xml"
    empty = dict.fromkeys(("geom", "joint", "inside", "world", "option", "flags", "sections"), "")
    path.write_text(FILE.format(**empty | given))
    return path


def test_everything_in_the_schema_is_decided_on() -> None:
    schema = [*items(mujoco.mj_printSchema(False, False))]
    assert len(schema) > 1000
    assert [item for item in schema if verdict(*item) is None] == []


@pytest.mark.parametrize("case", REFUSED)
def test_what_changes_the_motion_is_refused_unless_it_is_named(case: str, tmp_path: Path) -> None:
    word, given = REFUSED[case]
    path = written(tmp_path, given)
    with pytest.raises(sr.ModelError, match=rf"without which it moves differently.*ignore=\['{word}'\]"):
        sr.load_mjcf(path)
    assert any("left out" in note for note in sr.load_mjcf(path, ignore=[word]).notes)


@pytest.mark.parametrize("case", NOTED)
def test_what_is_left_out_is_noted(case: str, tmp_path: Path) -> None:
    words, given = NOTED[case]
    assert any(words in note for note in sr.load_mjcf(written(tmp_path, given)).notes)


@pytest.mark.parametrize("case", SILENT)
def test_what_moves_nothing_is_not_noted(case: str, tmp_path: Path) -> None:
    assert sr.load_mjcf(written(tmp_path, SILENT[case])).notes == ()


def test_everything_that_is_refused_is_named_at_once(tmp_path: Path) -> None:
    """With names from the file; the words of the message import it."""
    motor, tendon = (REFUSED[case][1]["sections"] for case in ("DC motor", "equality of a tendon"))
    path = written(tmp_path, {"sections": tendon + motor})
    with pytest.raises(sr.ModelError, match=r"\(equality0\).*\(actuator0\)") as caught:
        sr.load_mjcf(path)
    words = ["equalities", "actuators"]
    assert str(caught.value).endswith(f"import it with ignore={words}.")
    assert sr.load_mjcf(path, ignore=words)


def test_margins_that_overlap_are_refused_with_a_remedy(tmp_path: Path) -> None:
    path = written(tmp_path, {"joint": ' range="0 5" limited="true" margin="0.2"'})
    with pytest.raises(sr.ModelError, match=r'joint "j": has a margin of 0.2 .* ignore=\["limits"\]'):
        sr.load_mjcf(path)
    assert sr.load_mjcf(path, ignore=["limits"])


def test_an_inertia_taken_as_given_is_not_offered_again(tmp_path: Path) -> None:
    path = tmp_path / "model.urdf"
    inertial = (
        '<inertial><mass value="1"/><inertia ixx="-1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    links = f'<link name="a"/><link name="b">{inertial}</link>'
    joint = '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>'
    path.write_text(f'<robot name="r">{links}{joint}</robot>')
    with pytest.raises(sr.ModelError, match='as it is: inertia="given"'):
        sr.load(path)
    with pytest.raises(sr.ModelError, match="negative") as caught:
        sr.load(path, inertia="given")
    assert "as it is" not in str(caught.value)
