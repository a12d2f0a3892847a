"""Functions of a position: coordinates of points."""

import pytest

import sarrus as sr

POINT = sr.Body("tool", mass=1.0, inertia=(1, 1, 1)).point(0.1, 0.2, 0.3)


def test_coordinates_of_a_point() -> None:
    assert [one.label for one in POINT["x", "z"]] == ["tool(0.1, 0.2, 0.3).x", "tool(0.1, 0.2, 0.3).z"]


@pytest.mark.parametrize("axis", ["u", 0])
def test_other_names_are_refused(axis: object) -> None:
    with pytest.raises(sr.ModelError, match="axis must be x, y or z"):
        POINT[axis]


def test_a_point_is_no_sequence() -> None:
    """Else a point in place of its coordinates would be asked for another one without end."""
    with pytest.raises(sr.ModelError, match="axis must be x, y or z, but is 0"):
        tuple(POINT)
