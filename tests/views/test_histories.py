"""Figures of runs hold the curves, labels and units that they should, and draw into given axes."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from tests.analyses.driven import pendulum, turned
from tests.views.page_parts import read

import sarrus as sr
from sarrus import mechanisms
from sarrus.views import plot_sensitivities


@cache
def driven() -> sr.Trajectory:
    return sr.kinematics(turned(3.0, 0.5), np.linspace(0.0, 1.0, 21))


@cache
def free() -> sr.Trajectory:
    system = sr.System(sr.load(mechanisms.path("slider_crank")))
    return sr.simulate(system, sr.assemble(system), until=0.4, method=sr.HHT(), store="steps")


def axes() -> object:
    return Figure().subplots()


def test_time_histories_of_bodies_and_joints() -> None:
    above, below = driven().plot("slider.x", "pin.angle", "crank.y", ax=Figure())
    (slider, _), (pin,) = ([line.get_ydata() for line in ax.lines] for ax in (above, below))
    assert np.array_equal(slider, driven()["slider"].position[:, 0])
    assert pin == pytest.approx(driven().joint("pin").angle, rel=1e-13)
    assert (above.get_ylabel(), below.get_ylabel()) == ("[m]", "pin.angle [rad]")
    assert [text.get_text() for text in above.get_legend().get_texts()] == ["slider.x", "crank.y"]
    assert below.get_xlabel() == "t [s]"
    with pytest.raises(ValueError, match=r"1 axes for 2 panels. Give a list of 2 axes"):
        driven().plot("slider.x", "pin.angle", ax=axes())


def test_round_off_is_a_bound() -> None:
    t = np.linspace(0, 1, 50)
    force, noise = np.column_stack([t, 1 - t, t * t]), 3e-15 * np.sin(70 * np.column_stack([t, 2 * t, 3 * t]))
    made = sr.results.Reaction("pin", t, 0 * force, force, noise, np.broadcast_to(np.eye(3), (50, 3, 3)))
    above, below = made.plot()
    assert [text.get_text() for text in below.texts] == ["< 1e-14 N m"]
    assert below.get_ylim() == (-1, 1)
    assert not above.texts
    replaced = replace(driven(), q=np.where(driven().q == driven().q, 1e-16, 0.0))
    assert [text.get_text() for text in replaced.plot("slider.x", ax=axes()).texts] == ["< 1e-16 m"]


@pytest.mark.parametrize(
    ("name", "rates", "label"),
    [
        ("slider.x", False, "slider.x [m]"),
        ("guide.displacement", True, "rate of guide.displacement [m/s]"),
        ("pin.angle", True, "rate of pin.angle [rad/s]"),
        ("crank.e0", False, "crank.e0 [1]"),
    ],
)
def test_labels_with_units(name: str, rates: bool, label: str) -> None:
    ax = driven().plot(name, ax=axes(), rates=rates)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("t [s]", label)


def test_rates_are_rates() -> None:
    (line,) = driven().plot("guide.displacement", ax=axes(), rates=True).lines
    assert line.get_ydata() == pytest.approx(driven()["slider"].velocity[:, 0])


def test_phase_plane() -> None:
    ax = driven().plot_phase("pin.angle", ax=axes())
    assert ax.lines[0].get_xdata() == pytest.approx(driven().joint("pin").angle, rel=1e-13)
    assert ax.lines[0].get_ydata() == pytest.approx(driven().joint("pin").rate, rel=1e-12)
    assert ax.get_ylabel() == "rate of pin.angle [rad/s]"
    with pytest.raises(KeyError, match=r"has no output 'pin\.angel'"):
        driven().plot_phase("pin.angel", ax=axes())


def test_energies() -> None:
    ax = free().plot_energies(ax=axes())
    assert ax.lines[2].get_ydata() == pytest.approx(ax.lines[0].get_ydata() + ax.lines[1].get_ydata())
    assert ax.get_ylabel() == "energy [J]"
    with pytest.raises(ValueError, match="was made without energies"):
        replace(free(), kinetic_energy=np.zeros(0)).plot_energies(ax=axes())


def test_violation() -> None:
    positions, velocities = free().plot_violation(ax=Figure())
    t, envelope = positions.lines[0].get_data()
    assert len(t) <= 400
    assert np.all(np.interp(free().t, t, envelope) >= np.maximum(free().violation, 1e-17) * (1 - 1e-12))
    assert envelope.max() == free().violation.max()
    assert [ax.get_ylabel() for ax in (positions, velocities)] == [
        "|Φ| [m] or [1]",
        "|Φ_q v + Φ_t| [m/s] or [1/s]",
    ]


def test_steps() -> None:
    ax = free().plot_steps(ax=axes())
    assert np.sum(ax.lines[0].get_ydata()) == pytest.approx(0.4, rel=1e-6)
    assert ax.get_yscale() == "log"
    with pytest.raises(ValueError, match="was not made by steps"):
        replace(free(), history=np.zeros((0, 5))).plot_steps(ax=axes())


def test_sensitivities_over_time() -> None:
    found = sr.state_derivatives(free(), ["spring.k", "spring.c", "rod.mass"])
    above, below = plot_sensitivities(found, free(), "slider.x", ax=Figure(), most=2)
    sizes = {name: abs(found.q_b[:, 14, k]).max() for k, name in enumerate(found.names)}
    largest = sorted(sizes, key=lambda name: -sizes[name])[:2]
    units = {"rod.mass": "m/kg", "spring.k": "m²/N"}
    for ax, name in zip((above, below), largest, strict=True):
        assert [line.get_label() for line in ax.lines] == [name]
        assert ax.get_ylabel() == f"derivative of slider.x [{units[name]}]"
    assert np.array_equal(above.lines[0].get_ydata(), found.q_b[:, 14, found.names.index(largest[0])])


def test_a_mode_swings_about_its_rest(tmp_path: Path) -> None:
    system = pendulum(angle=0.0)
    found = sr.modes(system, system.q0)
    parts = read(found.animate(system, 0, tmp_path / "mode.html", amplitude=0.1))
    q = parts.array(parts.told["runs"][0]["q"], 7)
    assert q[[0, -1]] == pytest.approx(
        np.real(system.q0 + 0.1 * found.shapes[:, 0])[None].repeat(2, 0), abs=0.01
    )
    assert (q[0] + q[60]) / 2 == pytest.approx(system.q0, abs=0.01)
    assert np.linalg.norm(q[:, 3:], axis=1) == pytest.approx(1.0, abs=1e-6)
    assert parts.told["speed"] == pytest.approx(1 / (2 * found.frequencies[0]))
    assert parts.told["runs"][0]["name"].startswith("pendulum: mode 1, ")
    with pytest.raises(IndexError, match=r"There is no mode with the index 7. Choose 0 \(mode 1\)\."):
        found.animate(system, 7, tmp_path / "mode.html")


def test_outputs_over_another_output() -> None:
    run = driven()
    ax = run.plot("crank(0, 0.1, 0).y", over="crank(0, 0.1, 0).x", ax=axes())
    (line,) = ax.lines
    assert np.array_equal(line.get_xdata(), run["crank(0, 0.1, 0).x"])
    assert np.array_equal(line.get_ydata(), run["crank(0, 0.1, 0).y"])
    assert ax.get_xlabel() == "crank(0, 0.1, 0).x [m]"
    assert ax.get_aspect() == 1.0  # the path of a point is drawn to scale
    assert run.plot("pin.force.x", over="pin.angle", ax=axes()).get_aspect() == "auto"
    with pytest.raises(TypeError, match=r"Draw another over it by plot\('pin.angle', over='slider.x'\)"):
        run.plot_phase("slider.x", "pin.angle")


def test_vectors_are_drawn_by_components() -> None:
    ax = driven().plot("pin.force", ax=axes())
    assert [line.get_label() for line in ax.lines] == ["pin.force.x", "pin.force.y", "pin.force.z"]
    assert np.array_equal(driven()["pin.force"], driven().reaction("pin").force)


def test_long_labels_have_two_lines() -> None:
    """In a panel of two they are cut off otherwise."""
    figure = Figure(figsize=(7, 3.2), layout="constrained")
    driven().plot("motor.torque.x", "slider.x", ax=figure)
    above = figure.axes[0]
    figure.canvas.draw()
    assert above.get_ylabel() == "motor.torque.x\n[N m]"
    assert above.yaxis.label.get_window_extent().y1 <= figure.bbox.y1
