"""Old spellings of public names are accepted for one release, with a warning that names the new one."""

from __future__ import annotations

import pytest

import sarrus as sr
from sarrus import studies
from sarrus.model.deprecated import ATTRIBUTES, WITHDRAWN, with_former_names


def test_attributes_are_those_of_classes_that_have_them() -> None:
    for name, renamed in ATTRIBUTES.items():
        for old, new in renamed.items():
            assert isinstance(vars(getattr(studies, name))[old], property), (name, old)
            assert callable(getattr(getattr(studies, name), new)), (name, new)


def test_an_old_attribute_warns_and_is_the_new_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(ATTRIBUTES, "Wheel", {"turn": "rotation"})

    @with_former_names
    class Wheel:
        rotation = 3.0

    with pytest.warns(DeprecationWarning, match=r"Wheel\.turn is deprecated\. Use rotation\."):
        assert getattr(Wheel(), "turn") == 3.0  # noqa: B009


def test_a_withdrawn_name_is_refused_with_what_replaces_it() -> None:
    rod = sr.Body("rod", 1.0, (1.0, 1.0, 1.0))
    system = sr.System(sr.Model("free", [rod], []))
    run = sr.simulate(system, until=0.1, store="steps")
    found = {
        "sarrus": sr,
        "System": system,
        "Mobility": sr.mobility(system),
        "Gradient": sr.sensitivity(run, "rod.x", ["rod.mass"]),
        "Hessian": sr.hessian(run, "rod.x", ["rod.mass"]),
        "ErrorEstimate": run.error("rod.x"),
        "ModelError": sr.ModelError("it is wrong. Correct it."),
    }
    assert found.keys() == WITHDRAWN.keys()
    for kind, names in WITHDRAWN.items():
        for old, new in names.items():
            assert not hasattr(found[kind], old)
            with pytest.raises(AttributeError) as refused:
                getattr(found[kind], old)
            assert str(refused.value) == f"{kind}.{old} was withdrawn. Use {new}."
    assert "sr.verify(" in WITHDRAWN["Gradient"]["relative_errors"]
    assert callable(sr.verify)
