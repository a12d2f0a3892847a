"""Tables and figures of modes and reactions hold what they should."""

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
    figure = run.reaction("motor").plot()
    force, torque = figure.axes
    assert np.array_equal(torque.lines[2].get_ydata(), run.reaction("motor").torque[:, 2])
    assert [line.get_label() for line in force.lines] == ["x", "y", "z"]
    assert (force.get_ylabel(), torque.get_ylabel()) == ("force [N]", "torque [N m]")
    assert "motor" in force.get_title(loc="left")
