"""Parts are shown in one line: bodies within others by name, without what is left at its default."""

from __future__ import annotations

from dataclasses import dataclass, field

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


class Kept(sr.Model):
    """A user's own line is kept, also by what is derived from it."""

    def __repr__(self) -> str:
        return "mine"


class Derived(Kept):
    pass


class Weld(sr.Fixed, abstract=True):  # no kind of model files
    """The same of a part."""

    def __repr__(self) -> str:
        return "welded"


class Seam(Weld, abstract=True):
    pass


@dataclass(frozen=True, eq=False)
class Tagged(sr.Fixed, abstract=True):
    """Fields that are not shown stay so."""

    secret: str = field(default="", repr=False)


def test_own_lines_are_kept() -> None:
    assert repr(Kept("m", [CRANK])) == repr(Derived("m", [CRANK])) == "mine"
    at = {"point": (0, 0, 0)}
    assert repr(Weld("w", sr.ground, CRANK, **at)) == repr(Seam("w", sr.ground, CRANK, **at)) == "welded"
    assert "token" not in repr(Tagged("t", sr.ground, CRANK, **at, secret="token"))


WRONG = [
    sr.Model("m", None),  # type: ignore[arg-type]
    sr.Model("m", (x for x in [CRANK])),  # type: ignore[arg-type]
    sr.Model("m", [sr.Body("a", "1 kg", (1, 1, 1))]),  # type: ignore[arg-type]
    sr.Model("m", [sr.Body(5, 1.0, (1, 1, 1))], ["a joint"]),  # type: ignore[arg-type, list-item]
    sr.Model("m", [CRANK], [sr.Fixed("f", sr.Body(5, 1.0, (1, 1, 1)), CRANK, point="x")]),  # type: ignore[arg-type]
]


@pytest.mark.parametrize("model", WRONG, ids=range(len(WRONG)))
def test_a_model_that_is_not_yet_right_is_shown(model: sr.Model) -> None:
    assert repr(model).startswith("<Model m: ")
    assert "m: " in model._repr_html_()
    assert all(
        repr(part) for part in [*(model.joints or ()), *([] if model.bodies is None else model.bodies)]
    )


def test_what_is_wrong_is_shown_as_it_is() -> None:
    assert repr(sr.Point("crank", (0, 0, 0))) == "Point(crank, (0, 0, 0))"  # type: ignore[arg-type]
    assert repr(sr.Model("m", None)) == "<Model m: >"  # type: ignore[arg-type]
    assert repr(sr.Point(CRANK, ("a", None))) == "Point(crank, ('a', None))"
    assert "point='x'" in repr(sr.Revolute("pin", sr.ground, CRANK, point="x", axis=(0, 0, 1)))
