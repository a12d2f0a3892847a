"""Old spellings of public names are accepted for one release, with a warning that names the new one."""

from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
from sarrus.model import deprecated

SLIDE = """
name: drop
bodies: {block: {mass: 1, inertia: [1, 1, 1]}}
joints: {slide: {type: translational, bodies: [ground, block], point: [0, 0, 0], axis: [0, 0, 1]}}
drivers: {motor: {type: travel, joint: slide.travel, motion: 0.1*t}}
forces:
  end: {type: travel_stop, bodies: [ground, block], point: [0, 0, 0], axis: [0, 0, 1],
        stiffness: 1e3, damping: 0.1, lower: -1}
"""


@pytest.mark.parametrize(("old", "new"), deprecated.CLASSES.items())
def test_classes(old: str, new: str) -> None:
    with pytest.warns(DeprecationWarning, match=rf"sarrus\.{old} is deprecated\. Use {new}\."):
        assert getattr(sr, old) is getattr(sr, new)
    assert old not in sr.__all__


def test_attributes_are_those_of_classes_that_have_them() -> None:
    names = (
        "sarrus.results.mobility",
        "sarrus.analyses.workspace.tracing.explore",
        "sarrus.system",
        "sarrus.system.operators.joints",
        "sarrus.results.motion.parts",
        "sarrus.studies.table",
    )
    members = (
        getattr(module, word) for module in map(importlib.import_module, names) for word in dir(module)
    )
    found = {kind.__name__: kind for kind in members if isinstance(kind, type)}
    for name, renamed in deprecated.ATTRIBUTES.items():
        for old, new in renamed.items():
            assert isinstance(vars(found[name])[old], property), (name, old)
            assert new in {*dir(found[name]), *getattr(found[name], "__dataclass_fields__", ())}, (name, new)


def test_model_files_and_coordinates(tmp_path: Path) -> None:
    file = tmp_path / "drop.yaml"
    file.write_text(SLIDE)
    with pytest.warns(DeprecationWarning, match="is deprecated") as warnings:
        system = sr.System(sr.load(file))
    assert {str(one.message) for one in warnings} == {
        "type: travel is deprecated. Use type: displacement.",
        "type: travel_stop is deprecated. Use type: displacement_stop.",
        "travel is deprecated. Use displacement.",
    }
    joint, q = system.joint("slide"), sr.assemble(system).q
    with pytest.warns(DeprecationWarning, match=r"SystemJoint\.travel is deprecated\. Use displacement\."):
        assert joint.travel(q) == joint.displacement(q)
    with pytest.warns(DeprecationWarning, match=r"travel is deprecated\. Use displacement\."):
        assert joint["travel"].value(q) == joint.displacement(q)
    run = sr.kinematics(system, [0.0, 0.5, 1.0])
    with pytest.warns(DeprecationWarning, match=r"slide\.travel is deprecated\. Use slide\.displacement\."):
        assert np.array_equal(run.output("slide.travel").values, run.output("slide.displacement").values)
    with pytest.warns(DeprecationWarning, match=r"slide\.travel\.rate is deprecated"):
        run.output("slide.travel.rate")
    with pytest.raises(Exception, match="travle"):
        run.output("slide.travle")


def test_names_of_outputs() -> None:
    known = ["slide.displacement", "table.displacement_x.rate", "tool.rotation_z", "tool.turn_x", "travel.x"]
    with pytest.warns(DeprecationWarning, match=r"tool\.turn_z is deprecated\. Use tool\.rotation_z\."):
        assert deprecated.present_name("tool.turn_z", known) == "tool.rotation_z"
    with pytest.warns(DeprecationWarning, match=r"table\.travel_x\.rate is deprecated"):
        assert deprecated.present_name("table.travel_x.rate", known) == "table.displacement_x.rate"
    for name in ("tool.turn_x", "travel.x", "slide.travels", "arm.travel"):  # without a warning
        assert deprecated.present_name(name, known) == name
