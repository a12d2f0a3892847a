"""Old spellings of public names are accepted for one release, with a warning that names the new one."""

from __future__ import annotations

import pytest

from sarrus import studies
from sarrus.model.checks.deprecated import ATTRIBUTES, accepts_deprecated_attributes


def test_attributes_are_those_of_classes_that_have_them() -> None:
    for name, renamed in ATTRIBUTES.items():
        for old, new in renamed.items():
            assert isinstance(vars(getattr(studies, name))[old], property), (name, old)
            assert callable(getattr(getattr(studies, name), new)), (name, new)


def test_an_old_attribute_warns_and_is_the_new_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(ATTRIBUTES, "Wheel", {"turn": "rotation"})

    @accepts_deprecated_attributes
    class Wheel:
        rotation = 3.0

    with pytest.warns(DeprecationWarning, match=r"Wheel\.turn is deprecated\. Use rotation\."):
        assert getattr(Wheel(), "turn") == 3.0  # noqa: B009
