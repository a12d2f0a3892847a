"""Tables and figures of modes and reactions hold what they should."""

from collections.abc import Callable
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
from tests.analyses.driven import pendulum, turned

import sarrus as sr


def test_table_of_modes() -> None:
    system = pendulum(angle=np.pi)
    text = str(sr.modes(system, system.q0))
    assert "bob" in text
    assert "pendulum: this equilibrium is unstable" in text
    assert len(text.splitlines()) == 4
    assert [line.split()[0] for line in text.splitlines()[1:3]] == ["1", "2"]


def test_figure_of_modes() -> None:
    system = pendulum(angle=np.pi)
    ax, shares = sr.modes(system, system.q0).plot()
    shown = np.concatenate([points.get_offsets() for points in ax.collections])
    assert sorted(shown[:, 0]) == pytest.approx([-shown[:, 0].max(), shown[:, 0].max()])
    assert ax.get_legend_handles_labels()[1] == ["grows"]
    assert [bar.get_height() for bar in shares.patches] == pytest.approx([1.0, 1.0])
    assert shares.get_ylabel() == "share of the kinetic energy [1]"
    assert shares.get_xticklabels()[0].get_text().startswith("1\n")


def test_figure_of_a_reaction() -> None:
    run = sr.kinematics(turned(3.0, 0.5), np.linspace(0.0, 1.0, 11))
    force, torque = run.reaction("motor").plot()
    assert np.array_equal(torque.lines[2].get_ydata(), run.reaction("motor").torque[:, 2])
    assert [line.get_label() for line in force.lines] == ["x", "y", "z"]
    assert (force.get_ylabel(), torque.get_ylabel()) == ("force [N]", "torque [N m]")
    assert "motor" in force.get_title(loc="left")


DRAWN: dict[str, Callable[[], Any]] = {
    "modes": lambda: sr.modes(system := pendulum(angle=np.pi), system.q0),
    "reaction": lambda: sr.kinematics(turned(3.0, 0.5), [0.0, 1.0]).reaction("motor"),
    "study": lambda: sr.study(
        pendulum(angle=1.0).model, {"bob.mass": [1.0, 2.0]}, {"m": "bob.x"}, analysis=sr.Statics(), workers=1
    ),
}


@pytest.mark.parametrize("name", DRAWN)
def test_figures_are_shown_by_pyplot_or_drawn_into_a_given_one(name: str) -> None:
    found = DRAWN[name]()
    for figure in (None, plt.figure()):
        (axes, *_) = np.ravel(found.plot(ax=figure))
        assert axes.figure.number in plt.get_fignums()
        assert figure in (None, axes.figure)
    plt.close("all")
