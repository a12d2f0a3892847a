"""Gradients as tables and figures."""

import numpy as np
import pytest
from tests.sensitivity.test_gradients import swung

import sarrus as sr
from sarrus.results import Gradient

# Derivatives by HHT and generalized-α are only named and shown here; their errors do not matter
pytestmark = []


def test_numbers_are_ranked_by_their_influence() -> None:
    at, slopes = np.array([0.0, 2.0, -100.0, 0.0]), np.array([[9.0, 3.0, 0.1, 10.0]])
    found = Gradient(("x",), ("a", "b", "c", "d"), np.array([1.0]), at, slopes)
    assert found.ranked() == ["c", "b", "d", "a"]
    assert np.allclose(found.influences(), [0, 0.06, -0.1, 0])
    told = found.table(most=2).splitlines()
    assert told[0] == "x = 1"
    assert told[2].split() == ["c", "-100", "+0.1", "-0.1"]
    assert told[-1].strip() == "and 2 more of less influence"


def test_hardpoints_are_ranked_by_a_millimetre_wherever_the_origin_is() -> None:
    """1 % of a coordinate depends on the origin, and a coordinate of 0 would have no influence."""
    names, slopes = ("ball.x", "ball.z", "spring.k"), np.array([[9.0, 3.0, 0.002]])
    units = {"response_units": ("rad",), "units": ("m", "m", "N/m"), "table_units": ("mm", "mm", "")}
    found = Gradient(("x",), names, np.array([1.0]), np.array([0.0, 2.0, 200.0]), slopes, **units)
    assert found.ranked() == ["ball.x", "spring.k", "ball.z"]
    assert np.allclose(found.influences(), [0.009, 0.003, 0.004])
    assert found.largest()[0] == found.ranked()
    assert "by 1 % or 1 mm more" in found.table()
    points = Gradient(
        ("x",), names[:2], np.array([1.0]), np.array([0.0, 2.0]), slopes[:, :2], table_units=("m", "m")
    )
    assert points.table().splitlines()[1].split()[-4:] == ["by", "1", "mm", "more"]
    assert "for 1 mm more" in points.plot().get_xlabel()


def test_the_largest_influences_are_drawn() -> None:
    gradient = sr.sensitivity(swung("HHT"), "slider.x", ["spring.k", "spring.c", "rod.mass", "spring.force"])
    ax = gradient.plot()
    bars = {
        label.get_text(): bar.get_width() for label, bar in zip(ax.get_yticklabels(), ax.patches, strict=True)
    }
    assert set(bars) == {"spring.k", "spring.c", "rod.mass"}
    assert np.isclose(bars["spring.k"], 0.1 * gradient["spring.k"])


def test_each_response_has_its_panel() -> None:
    parameters = ["spring.k", "spring.c", "rod.mass"]
    gradient = sr.sensitivity(swung("HHT"), ["slider.x", "crank.e1"], parameters)
    axes = gradient.plot()
    assert [ax.get_xlabel() for ax in axes] == [
        "change of final of slider.x [m] for 1 % more",
        "change of final of crank.e1 [1] for 1 % more",
    ]
    for ax, row in zip(axes, gradient.matrix, strict=True):
        widest = max(ax.patches, key=lambda bar: abs(bar.get_width())).get_width()
        assert np.isclose(abs(widest), abs(0.01 * row * gradient.at).max())
    assert gradient.plot(response=1).get_xlabel() == axes[1].get_xlabel()
    with pytest.raises(ValueError, match="axes for 2 panels"):
        gradient.plot(axes[0])
