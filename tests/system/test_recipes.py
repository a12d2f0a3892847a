"""Recordings of built-in elements are known by a stored hash; those of users' elements are recorded each time."""

from __future__ import annotations

from pathlib import Path

import pytest

from sarrus import elements
from sarrus._jit.kernels.emit import Recording
from sarrus._jit.linking.cache import folder
from sarrus.algebra import Array
from sarrus.analyses.sensitivity.lagrangians.by_parameters import ADJOINT, _gradient
from sarrus.elements.element import Scalar
from sarrus.elements.recorder import Variant
from sarrus.system.curves import lanes
from sarrus.system.curves.lanes import Recipe, fingerprint

SPRING = Variant(elements.TSDA, (-1, 0))


@pytest.fixture(autouse=True)
def _new() -> None:
    """Nothing is known from other tests, as in a new process."""
    for function in (lanes.fingerprint, lanes._recorded, lanes._sources):
        function.cache_clear()


def recorded(made: list[Variant]) -> Recipe:
    """That of the gradient, which notes that it is recorded."""

    def make(variant: Variant, quantity: str) -> Recording:
        made.append(variant)
        return _gradient(variant, quantity)

    make.__name__, make.__module__ = "make", _gradient.__module__
    return Recipe(SPRING, make, "step", ADJOINT)


def test_a_built_in_element_is_recorded_once_for_all_processes() -> None:
    for file in folder().glob("make.*.value"):
        file.unlink()
    made: list[Variant] = []
    first = fingerprint(recorded(made))
    assert made == [SPRING]
    assert first == _gradient(SPRING, "step").fingerprint()
    fingerprint.cache_clear()
    assert fingerprint(recorded(made)) == first
    assert made == [SPRING]


def test_it_is_recorded_again_when_a_source_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[Variant] = []
    fingerprint(recorded(made))
    before = len(made)
    monkeypatch.setattr(lanes, "_sources", lambda module: "of-a-test")
    for file in folder().glob("make.*of-a-test.value"):
        file.unlink()
    fingerprint.cache_clear()
    fingerprint(recorded(made))
    assert len(made) == before + 1


def test_hash_of_sources_covers_the_folder_of_a_recording(monkeypatch: pytest.MonkeyPatch) -> None:
    first = lanes._sources(_gradient.__module__)
    read = Path.read_bytes

    def edited(file: Path) -> bytes:
        return read(file) + (b"#" if file.name == "elements.py" else b"")

    monkeypatch.setattr(Path, "read_bytes", edited)
    lanes._sources.cache_clear()
    assert lanes._sources(_gradient.__module__) != first


def test_elements_of_users_are_recorded() -> None:
    class Saddle(elements.Primitive, bodies=1, rows=1, derivatives="automatic", rare=True):
        """Φ = z - k x y."""

        k: Scalar

        def Phi(self, x: elements.Single) -> Array:
            return x.r[2:3] - self.k * x.r[0:1] * x.r[1:2]

    del elements.Element.registry["Saddle"]  # other tests see those of the package alone
    variant = Variant(Saddle, (0,))
    before = {*folder().glob("*.value")}
    found = fingerprint(Recipe(variant, _gradient, "place", ADJOINT))
    assert found == _gradient(variant, "place").fingerprint()
    assert {*folder().glob("*.value")} == before
