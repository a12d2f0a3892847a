"""Misuse from Python is one sentence that names the part and says what to do instead."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import sarrus as sr
from sarrus import elements
from sarrus.model.forces import Force
from sarrus.model.geometry.pose import Poses
from sarrus.model.primitive import Primitive

CRANK = sr.Body("crank", mass=1.0, inertia=(1, 1, 1))
ROD = sr.Body("rod", mass=1.0, inertia=(1, 1, 1))


class Free(Force):
    """A force that yields what it is given."""

    def __init__(self, *values: Any, bodies: tuple[str, ...] = ("crank",)) -> None:
        object.__setattr__(self, "name", "mine")
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "bodies", bodies)

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        yield Primitive(elements.Torque, self.bodies, self.values, "torque")  # type: ignore[attr-defined]


del Force.kinds["free"]  # of this test only

P: Any = (0.0, 0.0, 0.0)
WRONG: list[tuple[Any, str]] = [
    (
        sr.Revolute("a", "ground", CRANK, point=P, axis=(0, 0, 1)),  # type: ignore[arg-type]
        'joint "a": body_i must be a body, but is "ground". Give the Body object (or sarrus.ground)',
    ),
    (
        sr.Torque("t", "crank", torque=P),  # type: ignore[arg-type]
        'force "t": body must be a body, but is "crank". Give the Body object (or sarrus.ground)',
    ),
    (
        sr.TSDA("s", CRANK, ROD.point(1, 0, 0), k=1.0, length=1.0),  # type: ignore[arg-type]
        'force "s": point_i must be a point of a body, but is a Body. Give body.point(x, y, z)',
    ),
    (
        sr.TSDA("s", sr.Point("crank", P), ROD.point(1, 0, 0), k=1.0, length=1.0),  # type: ignore[arg-type]
        'force "s": point_i must be on a body, but is "crank". Give the Body object (or sarrus.ground)',
    ),
    (
        Free(),
        'force "mine": its element Torque (torque) takes 1 values (torque), but is given 0. Give one for each',
    ),
    (Free((1, 2)), "torque must have 3 numbers, but has 2. Give 3 numbers"),
    (Free("push"), 'torque must be a list of numbers, but is "push". Give 3 numbers'),
    (Free(P, bodies=("crank", "rod")), "is for 1 bodies, but is given 2. Name as many"),
    (Free(P, bodies=("crunk",)), 'there is no body "crunk". Did you mean "crank"?'),
]


@pytest.mark.parametrize(("part", "sentence"), WRONG, ids=range(len(WRONG)))
def test_a_part_of_wrong_things_is_refused(part: Any, sentence: str) -> None:
    is_joint = isinstance(part, sr.Revolute)
    parts: Any = {"joints": [part]} if is_joint else {"forces": [part]}
    with pytest.raises(sr.ModelError) as caught:
        sr.System(sr.Model("m", [CRANK, ROD], **parts))
    assert sentence in str(caught.value)


def test_a_part_alone_is_no_list() -> None:
    pin: Any = sr.Revolute("pin", sr.ground, CRANK, point=P, axis=(0, 0, 1))
    with pytest.raises(
        sr.ModelError, match=r"joints must be a list, but is a Revolute. Write \[...\] around it"
    ):
        sr.System(sr.Model("m", [CRANK], pin))


def test_a_system_is_made_of_a_model() -> None:
    wrong: Any = "crank.yaml"
    with pytest.raises(sr.ModelError, match=r'made of a Model, but this is "crank.yaml". Read a file with'):
        sr.System(wrong)


def test_a_table_that_is_none_says_so_by_name() -> None:
    with pytest.raises(sr.ModelError, match="curve: table must have at least two points"):
        sr.Curve.table([(0, 0)])


SAID = [
    (
        "k: {formula: 5 * l}",
        'k has no key "formula". Choose from table, periodic. Or give a number alone, without a key',
    ),
    ("k: 5, body: 1", 'has no key "body"'),
]


@pytest.mark.parametrize(("k", "sentence"), SAID)
def test_a_stiffness_may_be_a_number_too(k: str, sentence: str, tmp_path: Path) -> None:
    file = tmp_path / "m.yaml"
    points = "[{body: ground, at: [0, 0, 0]}, {body: rod, at: [0, 0, 1]}]"
    file.write_text(
        "name: m\nbodies: {rod: {mass: 1, inertia: [1, 1, 1]}}\n"
        f"forces: {{spring: {{type: tsda, points: {points}, length: 1, {k}}}}}\n"
    )
    with pytest.raises(sr.ModelError) as caught:
        sr.load(file)
    assert sentence in str(caught.value)


@pytest.mark.parametrize("kind", [sr.Revolute, sr.Fixed, sr.Bushing])
def test_frames_in_the_places_of_bodies_are_told_their_keywords(kind: type) -> None:
    body = sr.Body("rod", 1.0, (1.0, 1.0, 1.0))
    stiffness = {"stiffness": (1,) * 6} if kind is sr.Bushing else {}
    part = kind("one", sr.ground.frame((0, 0, 0)), body.frame((0, 0, 0)), **stiffness)
    parts = ([], [part]) if kind is sr.Bushing else ([part], [])
    with pytest.raises(sr.ModelError, match=r"but is a Frame\. Give it as frame_i=\."):
        sr.System(sr.Model("m", [body], *parts))
