"""A user's class that model files cannot describe refuses a file that uses it, and no other file."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from sarrus import elements
from sarrus.model import Force, ModelError, load
from sarrus.model.file import schema_text
from sarrus.model.geometry.pose import Poses
from sarrus.model.primitive import Primitive
from sarrus.model.quantity import Vector

if TYPE_CHECKING:
    from nowhere import Weather  # type: ignore[import-not-found]

BODIES = "name: m\nbodies:\n  bob: {mass: 1, inertia: [1, 1, 1]}\n"
PUSH = "forces:\n  push: {type: torque, body: bob, torque: [1, 0, 0]}\n"


class Gust:
    """What no file knows."""


@dataclass(frozen=True, eq=False)
class Windy(Force):
    """A field of a class of the user's."""

    gust: Gust

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        yield Primitive(elements.Torque, ("bob",), ((0.0, 0.0, 0.0),), "torque")


@dataclass(frozen=True, eq=False)
class Rainy(Windy):
    """An annotation that cannot be read."""

    weather: Weather | None = None


class Stormy(Windy):
    """Not a dataclass."""

    def __init__(self, *values: Any) -> None:
        object.__setattr__(self, "name", "storm")


@dataclass(frozen=True, eq=False)
class Typed(Windy):
    """A key that all have."""

    type: float = 0.0


@dataclass(frozen=True, eq=False)
class Hidden(Force):
    """Fields with names that the checked mapping has, too, and one whose default is made anew."""

    copy: float
    json: float = 2.0
    model_config: float = 3.0
    schema: Vector = field(default_factory=lambda: [1.0, 2.0, 3.0])

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        yield from ()


ANNOTATE = "Annotate it with one of the types of the built-in parts"
FORMLESS = f"there is no form for the type Gust of its field gust. {ANNOTATE}"
UNDESCRIBABLE: dict[str, tuple[type[Force], str]] = {
    "windy": (Windy, FORMLESS),
    "rainy": (Rainy, "name 'Weather' is not defined"),
    "stormy": (Stormy, "it has an __init__ of its own instead of the fields of a dataclass"),
    "typed": (Typed, FORMLESS),
}
for _name in (*UNDESCRIBABLE, "hidden"):
    del Force.kinds[_name]  # other tests see the kinds of the package


@pytest.fixture
def kinds(monkeypatch: pytest.MonkeyPatch) -> None:
    found = {name: kind for name, (kind, _) in UNDESCRIBABLE.items()}
    monkeypatch.setattr(Force, "kinds", {**Force.kinds, **found, "hidden": Hidden})


def written(tmp_path: Path, text: str) -> Path:
    (tmp_path / "m.yaml").write_text(text)
    return tmp_path / "m.yaml"


def test_other_files_are_read(kinds: None, tmp_path: Path) -> None:
    assert [force.name for force in load(written(tmp_path, BODIES + PUSH)).forces] == ["push"]


@pytest.mark.parametrize("name", UNDESCRIBABLE)
def test_the_type_is_refused_with_its_line(name: str, kinds: None, tmp_path: Path) -> None:
    with pytest.raises(ModelError) as caught:
        load(written(tmp_path, f"{BODIES}{PUSH}  blow: {{type: {name}, gust: 3}}\n"))
    message = f'has the type "{name}", which model files cannot describe: {UNDESCRIBABLE[name][1]}. Build it in Python.'
    assert str(caught.value) == f'{tmp_path / "m.yaml"}:6: force "blow": {message}'


def test_formulas_name_their_numbers_as_unknown(kinds: None, tmp_path: Path) -> None:
    text = f"{BODIES}{PUSH.replace('[1, 0, 0]', '[blow.weather, 0, 0]')}  blow: {{type: rainy, gust: 3}}\n"
    with pytest.raises(ModelError, match=r"m\.yaml:[56]: force"):
        load(written(tmp_path, text))


def test_the_schema_allows_none(kinds: None) -> None:
    definitions = json.loads(schema_text())["$defs"]
    assert definitions["Windy"]["properties"]["type"]["not"] == {}
    assert "not" not in definitions["Torque"]["properties"]["type"]


def test_a_field_may_have_any_name(kinds: None, tmp_path: Path) -> None:
    text = f"{BODIES}parameters: {{a: 4}}\nforces: {{f: {{type: hidden, copy: 2*a, model_config: f.copy}}}}\n"
    model = load(written(tmp_path, text))
    (force,) = model.forces
    assert isinstance(force, Hidden)
    assert (force.copy, force.json, force.model_config, force.schema) == (8.0, 2.0, 8.0, [1.0, 2.0, 3.0])
    assert ("forces", "f", "copy") in model.expressions
    with pytest.raises(ModelError, match=r'has no key "jsn". Did you mean "json"'):
        load(written(tmp_path, f"{BODIES}forces: {{f: {{type: hidden, copy: 1, jsn: 2}}}}\n"))
