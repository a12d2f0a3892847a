"""Pictures of studies: contours over two parameters, a row of panels for each response, units on every axis."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.collections import Collection

from sarrus.studies import StudyTable

UNITS = {"spring.k": "N/m", "rod.mass": "kg", "reach": "m", "load": "N"}


def table(parameters: tuple[str, ...], failed: int = 0) -> StudyTable:
    random = np.random.default_rng(3)
    values = random.uniform(1, 2, size=(30, len(parameters)))
    found = np.column_stack([values.sum(axis=1), values.prod(axis=1)])
    found[:failed] = np.nan
    success = np.isfinite(found[:, 0])
    messages = tuple("" if good else "failed" for good in success)
    seconds = np.ones(30)
    return StudyTable(
        "s", parameters, ("reach", "load"), values, found, success, messages, seconds, {"units": UNITS}
    )


def test_two_parameters_are_a_contour_with_cases_marked() -> None:
    axes = table(("spring.k", "rod.mass"), failed=2).plot()
    assert len(axes) == 4  # a contour and a distribution for each response
    contour, distribution = axes[:2]
    assert (contour.get_xlabel(), contour.get_ylabel()) == ("spring.k [N/m]", "rod.mass [kg]")
    assert contour.get_title(loc="left") == "reach [m]"
    assert distribution.get_xlabel() == "reach [m]"
    assert axes[2].get_title(loc="left") == "load [N]"
    assert any(isinstance(one, Collection) for one in contour.collections)
    marked, failed = contour.lines
    assert (len(marked.get_xdata()), len(failed.get_xdata())) == (28, 2)
    assert len(contour.figure.axes) == 6  # with two scales of colours


@pytest.mark.filterwarnings("error")
def test_contours_fill_their_panels() -> None:
    """A curve of no points without clipping made the layout of several rows collapse."""
    axes = table(("spring.k", "rod.mass")).plot("reach", "load")
    axes[0].figure.canvas.draw()
    assert min(ax.get_position().height for ax in axes) > 0.3


def test_cases_of_one_parameter_are_joined() -> None:
    joined, apart = table(("spring.k",)).plot("load")[0], table(("spring.k", "a", "b")).plot("load")[0]
    assert [len(line.get_xdata()) for line in joined.lines] == [30]
    assert not apart.lines


def test_one_parameter_is_a_panel_for_each_response() -> None:
    axes = table(("spring.k",)).plot()
    assert [ax.get_ylabel() for ax in axes] == ["reach [m]", "cases", "load [N]", "cases"]
    assert [ax.get_xlabel() for ax in axes] == ["spring.k [N/m]", "reach [m]", "spring.k [N/m]", "load [N]"]
    assert len(table(("spring.k",)).plot("load")) == 2


def test_parameters_on_a_line_are_no_contour() -> None:
    one = table(("spring.k", "rod.mass"))
    one.values[:, 1] = 2 * one.values[:, 0]
    assert [ax.get_ylabel() for ax in one.plot("reach")] == ["reach [m]", "", "cases"]


def test_errors_of_simulations_are_no_contour() -> None:
    found = table(("spring.k", "rod.mass"))
    found.found[:, 0] = 3.0 + 1e-6 * found.found[:, 0]
    reach, _, load, _ = found.plot()
    assert [any(isinstance(one, Collection) for one in ax.collections) for ax in (reach, load)] == [
        False,
        True,
    ]
