"""Outputs without a map are refused: a map of them had no end, and a range "from nowhere"."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import sarrus as sr


@pytest.fixture(scope="module")
def arm() -> sr.System:
    """Two links in the plane x, z."""
    upper = sr.Body("upper", mass=1, inertia=(1, 1, 1))
    lower = sr.Body("lower", mass=1, inertia=(1, 1, 1), position=(2, 0, 0))
    joints = [
        sr.Revolute("p", sr.ground, upper, point=(0, 0, 0), axis=(0, 1, 0)),
        sr.Revolute("q", upper, lower, point=(1.5, 0, 0), axis=(0, 1, 0)),
    ]
    return sr.System(sr.Model("arm", [upper, lower], joints))


@pytest.mark.parametrize(
    ("analysis", "output", "message"),
    [
        (sr.workspace, ("lower.rotation_y", "lower.y"), "lower.y does not change in any motion of arm"),
        (sr.WorkspaceMap, ("lower.y", "lower.z"), "lower.y does not change in any motion of arm"),
        (sr.workspace_range, "lower.y", "lower.y does not change in any motion of arm"),
        (sr.workspace_range, "upper.x", "upper.x does not change in any motion of arm"),
        (
            sr.workspace_volume,
            ("lower.x", "lower.z", "p"),
            "depend on each other, so that they cover no volume",
        ),
    ],
)
def test_outputs_that_cover_nothing_are_refused(
    arm: sr.System, analysis: Any, output: Any, message: str
) -> None:
    with pytest.raises(sr.SarrusError, match=f"^output: .*{message}"):
        analysis(arm, output)


def test_outputs_that_are_dependent_where_the_mechanism_is_drawn_are_mapped() -> None:
    links = [sr.Body("a", 1, (1, 1, 1)), sr.Body("b", 1, (1, 1, 1), position=(1, 0, 0))]
    joints = [
        sr.Revolute("p", sr.ground, links[0], point=(0, 0, 0), axis=(0, 0, 1)),
        sr.Revolute("q", links[0], links[1], point=(1, 0, 0), axis=(0, 0, 1)),
    ]
    stretched = sr.System(sr.Model("stretched", links, joints))
    found = sr.workspace(stretched, links[1].point(0.5, 0, 0)["x", "y"], verify=False)
    assert found.area == pytest.approx(np.pi * (1.5**2 - 0.5**2), rel=1e-6)
