"""Each attribute of an actuator, a tendon and a joint of MJCF has the effect on the import that the schema states."""

from pathlib import Path
from typing import Any

import pytest
from tests.io.mjcf_schema import ACTUATORS, NO_MOTION, NOTED, REFUSED, items, verdict

import sarrus as sr

mujoco = pytest.importorskip("mujoco", "4.0")  # which has all of them
pytestmark = pytest.mark.needs("mujoco")

BODIES = """<worldbody><site name="w" pos="0.3 1 0.4"/><body gravcomp="0.5"><joint name="j"{}/><geom size="0.1"/>
<site name="s" pos="0.3 0 0"/><body name="c" pos="0.5 0 0"><joint name="k" range="-1 1"/><geom size="0.1"/></body>
</body></worldbody>"""
TENDONS = """<tendon><spatial name="t"{}><site site="s"/><site site="w"/></spatial><fixed name="f"{}>
<joint joint="k" coef="2"/></fixed></tendon>"""
MOTORS = {
    "body/joint": '<motor joint="j"/>',
    "tendon/spatial": '<motor tendon="t"/>',
    "tendon/fixed": '<motor tendon="f"/>',
}
PLACES = "body/joint", "tendon/spatial", "tendon/fixed", *(f"actuator/{kind}" for kind in ACTUATORS)
BASE: dict[str, dict[str, str]] = {  # attributes that an element needs
    "actuator/muscle": {"lengthrange": "0.2 4"},
    "actuator/damper": {"ctrlrange": "0 1", "kv": "3"},
    "actuator/intvelocity": {"actrange": "-1 1"},
}
CRANK = {"cranksite": "s", "slidersite": "w", "cranklength": "1"}
INSTEAD = {  # of the joint of an actuator
    "body": {"body": "c"},
    **dict.fromkeys(CRANK, CRANK),
    "jointinparent": {"jointinparent": "k"},
    "refsite": {"site": "s", "refsite": "w"},
    "site": {"site": "s"},
    "tendon": {"tendon": "t"},
}
DELAY = {"joint": "j", "nsample": "5", "delay": "0.02", "interp": "linear"}
INSTEAD |= dict.fromkeys(("delay", "interp", "nsample"), DELAY)
INSTEAD |= {"actuator/muscle/forcelimited": {"joint": "j", "forcelimited": "true", "forcerange": "-1 1"}}
INSTEAD |= {"inheritrange": {"joint": "k", "inheritrange": "1"}, "actdim": {"joint": "j", "dyntype": "user"}}
WITH: dict[str, dict[str, str]] = {  # others that an attribute needs to have an effect
    **{name: {"dyntype": "filter"} for name in ("actearly", "dynprm", "actrange")},
    "actlimited": {"dyntype": "filter", "actrange": "-1 1"},
    **{name: {} for name in ("actuator/intvelocity/actlimited", "actuator/intvelocity/actrange")},
    "actuator/muscle/forcelimited": {},
    "actuator/general/lengthrange": {
        "gaintype": "muscle",
        "gainprm": "0.75 1.05 30 1 0.5 1.6 1.5 1.3 1.2",
        "lengthrange": "0.2 4",
    },
    "biasprm": {"biastype": "affine"},
    "biastype": {"biasprm": "1 2 3"},
    "gaintype": {"gainprm": "1 2 3"},
    "ctrllimited": {"ctrlrange": "0 1"},
    "forcelimited": {"forcerange": "-1 1"},
    **{name: {"actuatorfrcrange": "-1 1"} for name in ("actuatorfrclimited", "actuatorgravcomp")},
    **{name: {"range": "-1 1"} for name in ("limited", "margin", "solimplimit", "solreflimit")},
    **{name: {"frictionloss": "0.1"} for name in ("solimpfriction", "solreffriction")},
    **{name: {"stiffness": "3"} for name in ("ref", "springlength", "springref", "springyield")},
}
RANGES = "actuatorfrcrange", "actrange", "ctrlrange", "forcerange", "range", "velrange", "ffrange"
VALUES = {
    **dict.fromkeys(RANGES, "0.2 1.8"),
    **dict.fromkeys(("actearly", "actuatorgravcomp"), "true"),
    **dict.fromkeys(("actlimited", "actuatorfrclimited", "ctrllimited", "forcelimited", "limited"), "false"),
    **dict.fromkeys(("biastype", "gaintype"), "affine"),
    **dict.fromkeys(("biasprm", "bias", "pos", "axis"), "1 2 3"),
    **dict.fromkeys(("solreflimit", "solreffriction", "springdamper"), "0.05 1"),
    **dict.fromkeys(("solimplimit", "solimpfriction"), "0.8 0.85 0.01"),
    "dyntype": "filter",
    "group": "3",
    "input": "vel",
    "joint": "k",
    "lengthrange": "0.3 3",
    "lmin": "0.3",
    "margin": "0.01",
    "rgba": "1 0 0 1",
    "springref": "0.2",
    "timeconst": "0.02 0.06",
    "type": "slide",
}
NAMES = {"class", "name", "material"}


def attributes() -> list[tuple[str, str]]:
    schema = items(mujoco.mj_printSchema(False, False))
    return [item for item in schema if item[0] in PLACES and item[1] and item[1] not in NAMES]


def imported(path: Path, place: str, given: dict[str, str]) -> tuple[str, tuple[str, ...]] | None:
    """Return the parts and the notes; None if the file is refused."""
    text = "".join(f' {name}="{value}"' for name, value in given.items())
    own = [text if place == one else "" for one in PLACES[:3]]
    actuator = MOTORS.get(place, f"<{place.partition('/')[2]}{text}/>")
    sections = BODIES.format(own[0]) + TENDONS.format(*own[1:]) + f"<actuator>{actuator}</actuator>"
    path.write_text(f'<mujoco><option actuatorgroupdisable="3"/>{sections}</mujoco>')
    try:
        robot = sr.load_mjcf(path)
    except sr.ModelError:
        return None
    return repr((robot.bodies, robot.joints, robot.forces)), robot.notes


@pytest.mark.parametrize("place", PLACES)
def test_no_attribute_is_ignored_in_silence(place: str, tmp_path: Path) -> None:
    for _, name in [one for one in attributes() if one[0] == place]:
        on: dict[str, Any] = {"joint": "j"} if place.startswith("actuator") else {}
        other, instead = (one.get(f"{place}/{name}", one.get(name, {})) for one in (WITH, INSTEAD))
        before = on | BASE.get(place, {}) | other
        after = before | {name: "2" if name in ("springlength", "springyield") else VALUES.get(name, "2")}
        if instead:
            after = {k: v for k, v in before.items() if k != "joint"} | instead
        first, second = (imported(tmp_path / "model.xml", place, given) for given in (before, after))
        assert first is not None, (name, before)
        found = verdict(place, name)
        if found == NO_MOTION:
            assert second == first, name
        elif found == REFUSED:
            assert second is None, name
        elif found == NOTED:
            assert second is None or second[1] != first[1], name
        else:
            assert second != first, name
