"""Nothing of an SDF file is ignored in silence: each element and attribute of the format is used, noted or refused."""

from __future__ import annotations

from pathlib import Path

import pytest

import sarrus as sr
from sarrus.io.sdf.specification import NOTED, REFUSED, USED

SPECIFICATION = Path(__file__).parent / "data" / "sdf-specification.txt"
INCLUDED = ("world/include", "model/include")  # which are replaced by what they name


def specified() -> dict[str, list[str]]:
    rows = (line.split(":") for line in SPECIFICATION.read_text().splitlines())
    return {path: names.split() for path, names in rows}


def noted(path: str) -> bool:
    """Whether an element or one around it has a note."""
    parts = path.split("/")
    paths = ["/".join(parts[:n]) for n in range(2, len(parts) + 1)]
    return any(one in NOTED or (one not in USED and f"{one.rpartition('/')[0]}/*" in NOTED) for one in paths)


def test_each_item_of_the_specification_is_used_noted_or_refused() -> None:
    for path, names in specified().items():
        if not path.startswith(INCLUDED):
            assert path in USED or noted(path), path
            assert noted(path) or not {*names} - {*USED[path].split()}, path


def test_what_is_used_or_refused_is_in_the_specification() -> None:
    """Apart from what only older versions have."""
    old = ("use_parent_model_frame", "initial_position")
    for path in (*USED, *REFUSED):
        assert path in specified() or path == "sdf" or path.endswith(old), path


INSIDE = {
    "1 sensor is left out": '<sensor name="s" type="imu"/>',
    "1 collision shape is left out: there is no contact": '<collision name="c"/>',
    "1 setting <kinematic> is left out: links move by forces": "<kinematic>false</kinematic>",
    "1 setting of the looks of links is": '<light name="l" type="spot"/>',
    "1 element <novelty> is left out": "<novelty/>",
    "the attribute name of 1 element <pose>": '<pose name="p">0 0 0 0 0 0</pose>',
    "planes, terrains": '<visual name="v"><geometry><plane/></geometry></visual>',
}


@pytest.mark.parametrize("note", INSIDE)
def test_what_is_left_out_of_links_is_noted(note: str, tmp_path: Path) -> None:
    path = tmp_path / "model.sdf"
    path.write_text(f'<sdf version="1.9"><model name="m"><link name="a">{INSIDE[note]}</link></model></sdf>')
    assert any(note in one for one in sr.load_sdf(path).notes)


def test_plugins_and_worlds_are_noted(tmp_path: Path) -> None:
    path = tmp_path / "model.world"
    inside = (
        '<model name="m"><link name="a"/><plugin name="p" filename="p.so"/></model><scene/><light name="l"/>'
    )
    path.write_text(f'<sdf version="1.9"><world name="w">{inside}</world></sdf>')
    notes = sr.load_any(path).notes
    assert "1 plugin is left out: what it does to the motion is not known" in notes
    assert any(note.startswith("2 settings of the world are left out") for note in notes)
