"""The counts that the paper gives for its two mechanisms."""

from tests.system.mechanisms import hmmwv, slider_crank


def test_slider_crank() -> None:
    counts = slider_crank().counts()
    assert counts["bodies"] == 3
    assert counts["coordinates"] == 21
    assert (counts["joint_equations"], counts["normalizations"]) == (17, 3)
    assert counts["degrees_of_freedom"] == 1


def test_hmmwv() -> None:
    counts = hmmwv().counts()
    assert counts["bodies"] == 14
    assert counts["coordinates"] == 98
    assert (counts["joint_equations"], counts["normalizations"]) == (73, 14)
    assert counts["degrees_of_freedom"] == 11
    basic = [counts[kind] for kind in ("Spherical", "Distance", "Dot1", "Dot2")]
    assert basic == [16, 4, 19, 2]


def test_rows_cover_the_joint_equations_once() -> None:
    rows = [row for found in hmmwv().rows.values() for row in found]
    assert sorted(rows) == list(range(73))


def test_names() -> None:
    system = slider_crank()
    assert system.row_names[:3] == ["pin: point x", "pin: point y", "pin: point z"]
    assert system.row_names[-1].startswith("slider:")
    assert system.coordinate_names[7] == f"{system.bodies[1]}.r.x"
    assert len(system.parameter_names) == system.nb
    assert system.b[system.parameter_names.index("spring[tsda].k")] == 10
