"""Parts are shown in one line: bodies within others by name, without what is left at its default."""

from __future__ import annotations

import pytest

import sarrus as sr
from sarrus import mechanisms

CRANK = sr.Body("crank", mass=2.0, inertia=(1, 2, 3), position=(0.5, 0, 0))
PARTS = [
    (CRANK, "Body('crank', mass=2.0, inertia=(1, 2, 3), position=(0.5, 0, 0))"),
    (CRANK.point(0.1, 0, 0), "Point(crank, (0.1, 0, 0))"),
    (sr.ground.global_point(0, 0, 1), 'Point(ground, (0, 0, 1), "global")'),
    (
        sr.Revolute("pin", sr.ground, CRANK, point=(0, 0, 0), axis=(0, 0, 1)),
        "Revolute('pin', ground, crank, point=(0, 0, 0), axis=(0, 0, 1))",
    ),
    (
        sr.TSDA("spring", sr.ground.point(0, 0, 0), CRANK.point(1, 0, 0), k=10.0, c=0.5, length=1.0),
        "TSDA('spring', point_i=Point(ground, (0, 0, 0)), point_j=Point(crank, (1, 0, 0)), k=10.0, length=1.0, c=0.5)",
    ),
]


@pytest.mark.parametrize(("part", "line"), PARTS, ids=lambda x: type(x).__name__)
def test_one_line(part: object, line: str) -> None:
    assert repr(part) == line


@pytest.mark.parametrize("name", ["slider_crank", "hmmwv"])
def test_no_part_has_another_in_it(name: str) -> None:
    model = sr.load(mechanisms.path(name))
    for part in [*model.joints, *model.drivers, *model.forces]:
        assert "Body(" not in repr(part)
        assert "\n" not in repr(part)


def test_what_is_wrong_is_shown_as_it_is() -> None:
    assert repr(sr.Point("crank", (0, 0, 0))) == "Point(crank, (0, 0, 0))"  # type: ignore[arg-type]
    assert repr(sr.Model("m", None)) == "<Model m: >"  # type: ignore[arg-type]
    assert repr(sr.Point(CRANK, ("a", None))) == "Point(crank, ('a', None))"
    assert "point='x'" in repr(sr.Revolute("pin", sr.ground, CRANK, point="x", axis=(0, 0, 1)))
