"""A model in words."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sarrus import mechanisms
from sarrus.model import AngleDriver, Body, Model, Revolute, describe, ground, load
from sarrus.model.expansion.blueprint import blueprint
from sarrus.model.words import mass_and_center


def test_the_slider_crank_in_words() -> None:
    file = mechanisms.path("slider_crank")
    assert describe(load(file)).splitlines() == [
        f"slider-crank, from {file}; gravity (0, 0, -9.81) m/s²",
        "3 bodies: crank, rod, slider; 3 kg in all, centre of mass at (2.086, 0.1804, 1.085) m",
        "4 joints, 17 equations:",
        "  1 revolute: pin",
        "  1 spherical: ball",
        "  1 universal: cross",
        "  1 translational: guide",
        "1 force:",
        "  1 tsda: spring",
        "degrees of freedom: 6 × 3 − 17 = 1, if no equation is redundant",
    ]


def test_findings_of_analyses_follow_the_degrees_of_freedom() -> None:
    lines = describe(load(mechanisms.path("slider_crank")), "equation pin: f_i.h_j is redundant").splitlines()
    assert lines[-1] == "equation pin: f_i.h_j is redundant"


def test_a_door_on_two_hinges_has_redundant_equations() -> None:
    door = Body("door", 2, (1, 1, 1), position=(1, 0, 0), center_of_mass=(1, 0, 0))
    hinges = [Revolute(f"hinge{z}", ground, door, point=(0, 0, z), axis=(0, 0, 1)) for z in (1, 2)]
    lines = describe(Model("door", [door], hinges)).splitlines()
    assert lines[0] == "door; no gravity"
    assert lines[1] == "1 body: door; 2 kg in all, centre of mass at (2, 0, 0) m"
    assert lines[2:5] == ["2 joints, 10 equations:", "  2 revolute: hinge1, hinge2", "no forces"]
    assert lines[5].endswith("6 × 1 − 10 = -4; there are redundant equations, or it cannot move")


def test_the_centre_of_mass_is_that_of_all_bodies_as_they_are_turned() -> None:
    half_turn = (0, 0, 0, 1)
    one = Body("one", 1, (1, 1, 1), orientation=half_turn, center_of_mass=(1, 0, 0))
    two = Body("two", 3, (1, 1, 1), position=(1, 4, 0))
    mass, center = mass_and_center(blueprint(Model("m", [one, two])))
    assert mass == 4
    np.testing.assert_allclose(center, [(-1 + 3) / 4, 3, 0], atol=1e-15)


def test_parameters_are_told_and_long_lists_are_cut(tmp_path: Path) -> None:
    bodies = "".join(f"  b{n}: {{mass: m, inertia: [1, 1, 1]}}\n" for n in range(20))
    (tmp_path / "m.yaml").write_text(f"name: many\nparameters: {{m: 2 g}}\nbodies:\n{bodies}")
    told = describe(load(tmp_path / "m.yaml"))
    assert "20 bodies: b0, b1," in told
    assert "b11 and 8 more; 0.04 kg in all" in told
    assert told.splitlines()[-1] == "1 parameter in SI units: m = 0.002; 20 numbers given by formulas"
    assert "b12" not in told


@pytest.mark.parametrize("name", mechanisms.names())
def test_every_shipped_mechanism_can_be_drawn(name: str, tmp_path: Path) -> None:
    from sarrus.views import mechanism_figure

    model = load(mechanisms.path(name))
    figure = mechanism_figure(model)
    figure.savefig(tmp_path / "m.svg")
    written = {text.get_text().strip() for text in figure.axes[0].texts}
    assert {body.name for body in model.bodies} <= written
    if name == "slider_crank":
        assert {"pin", "ball", "cross, guide", "spring"} <= written


def test_drivers_are_told() -> None:
    wheel = Body("wheel", 1.0, (1, 1, 1))
    pin = Revolute("pin", ground, wheel, point=(0, 0, 0), axis=(0, 0, 1))
    lines = describe(
        Model("driven", [wheel], [pin], drivers=[AngleDriver("motor", "pin", "2*t")])
    ).splitlines()
    assert lines[4:6] == ["1 driver, 1 equation:", "  1 angle: motor"]
    assert lines[-1] == "degrees of freedom: 6 × 1 − 6 = 0, if no equation is redundant"
