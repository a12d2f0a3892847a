"""Forces of a fluid on bodies of MJCF are those of MuJoCo; a box that falls reaches its speed."""

from pathlib import Path

import numpy as np
import pytest
from tests.io.beside_mujoco import compare_accelerations

import sarrus as sr

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.needs("mujoco")

FILE = """<mujoco><option {option}/><worldbody><body name="a" euler="10 20 30"><joint axis="1 2 3"/>
  <geom type="box" size="0.1 0.2 0.3" pos="0.1 0 0.3" euler="40 0 10"/>
  <body name="fixed" pos="0 0.3 0" euler="0 30 0"><geom type="capsule" size="0.1 0.2" pos="0.2 0 0"/></body>
  <body name="b" pos="0 0 0.6" gravcomp="0.3"><joint type="ball" damping="0.1"/>
    <geom type="ellipsoid" size="0.1 0.2 0.3" pos="0 0.1 0.2" euler="0 10 20"/></body></body>
  <body name="c" pos="1 0 0"><freejoint/><geom type="box" size="0.05 0.1 0.2" pos="0 0.1 0"/></body>
  </worldbody></mujoco>
"""
OPTIONS = {
    "density": 'density="1000"',
    "viscosity": 'viscosity="3"',
    "both in a wind": 'density="800" viscosity="2" wind="1 -2 3"',
}


@pytest.mark.parametrize("case", OPTIONS)
def test_a_fluid_acts_as_in_mujoco(case: str, tmp_path: Path) -> None:
    """On every body of the file by itself, also on one that is fixed to another."""
    path = tmp_path / "model.xml"
    path.write_text(FILE.format(option=OPTIONS[case]))
    assert sum(isinstance(force, sr.BoxDrag) for force in sr.load_mjcf(path).forces) == 4
    compare_accelerations(path, ignore=["limits", "contacts"])
    assert not any(isinstance(force, sr.BoxDrag) for force in sr.load_mjcf(path, ignore=["fluid"]).forces)


SHAPES = {
    "sphere": 'size="0.2"',
    "capsule": 'size="0.1 0.2"',
    "box": 'size="0.1 0.2 0.15"',
    "cylinder": 'size="0.2 0.1"',
    "ellipsoid": 'size="0.1 0.3 0.2"',
}
COEFFICIENTS = {
    "added mass": "0 0 0 0 0",
    "blunt drag": "0.7 0 0 0 0",
    "slender drag": "0 0.4 0 0 0",
    "angular drag": "0 0 1.3 0 0",
    "Kutta lift": "0 0 0 1.1 0",
    "Magnus lift": "0 0 0 0 0.9",
    "all": "0.7 0.4 1.3 1.1 0.9",
}
LIFTED = """<mujoco><option {option}/><worldbody><body name="a" euler="10 20 30"><joint axis="1 2 3"/>
  <geom name="fin" type="{kind}" {size} {fluid} pos="0.1 0 0.3" euler="40 0 10"/>
  <geom type="sphere" size="0.1" pos="0.4 0 0"/>
  <body name="fixed" pos="0 0.3 0" euler="0 30 0"><geom type="{kind}" {size} {fluid} pos="0.2 0 0"/></body></body>
  <body name="c" pos="1 0 0"><freejoint/><geom type="{kind}" {size} {fluid} pos="0 0.1 0" euler="10 20 40"/></body>
  <body name="d" pos="2 0 0"><freejoint/><geom type="box" size="0.1 0.2 0.3"/></body>
  </worldbody></mujoco>
"""


@pytest.mark.one_in(8)
@pytest.mark.parametrize("kind", SHAPES)
@pytest.mark.parametrize("case", COEFFICIENTS)
def test_lift_acts_as_in_mujoco(case: str, kind: str, tmp_path: Path) -> None:
    """Each coefficient by itself, and all together with viscosity and wind; other bodies have the box."""
    path, fluid = tmp_path / "model.xml", f'fluidshape="ellipsoid" fluidcoef="{COEFFICIENTS[case]}"'
    option = 'density="1000"' + (' viscosity="30" wind="1 -2 3"' if case == "all" else "")
    path.write_text(LIFTED.format(option=option, kind=kind, size=SHAPES[kind], fluid=fluid))
    names = [force.name for force in sr.load_mjcf(path).forces if isinstance(force, sr.EllipsoidDrag)]
    assert names == ["fin_fluid", "geom2_fluid", "geom3_fluid"]
    compare_accelerations(path, ignore=["limits", "contacts"], rtol=1e-10)


def test_viscosity_alone_acts_on_shapes(tmp_path: Path) -> None:
    path, fluid = tmp_path / "model.xml", 'fluidshape="ellipsoid"'
    path.write_text(LIFTED.format(option='viscosity="3"', kind="box", size=SHAPES["box"], fluid=fluid))
    compare_accelerations(path, ignore=["limits", "contacts"], rtol=1e-10)


def test_passive_forces_are_disabled_together(tmp_path: Path) -> None:
    """Without springs and dampers MuJoCo has no forces of a fluid, and no compensated weights."""
    path = tmp_path / "model.xml"
    text = FILE.format(option='density="1000"')
    path.write_text(
        text.replace("<worldbody>", '<option><flag spring="disable" damper="disable"/></option><worldbody>')
    )
    compare_accelerations(path, ignore=["limits", "contacts"])
    assert not sr.load_mjcf(path, ignore=["limits", "contacts"]).forces


def test_a_box_that_falls() -> None:
    """The speed is that where drag is equal to the weight, and energy is the weight's work less what is dissipated."""
    box = sr.Body("box", 20.0, (1, 1, 1))
    drag = sr.BoxDrag("drag", box.frame((0, 0, 0)), (0.2, 0.3, 0.1), density=1000.0)
    run = sr.simulate(sr.System(sr.Model("m", [box], forces=[drag], gravity=(0, 0, -9.81))), until=5.0)
    fall = np.sqrt(20 * 9.81 / (0.5 * 1000 * 0.2 * 0.3))
    assert run["box.velocity.z"][-1] == pytest.approx(-fall, rel=1e-5)
    assert run["drag.dissipated_power"][-1] == pytest.approx(20 * 9.81 * fall, rel=1e-5)


@pytest.mark.slow
def test_every_operator_and_derivatives() -> None:
    """Also of a run, by differences of whole runs."""

    def system(density: float, viscosity: float) -> sr.System:
        body = sr.Body("a", 2.0, (0.1, 0.2, 0.25), velocity=(1, 2, 3), angular_velocity=(3, 2, 1))
        frame = body.frame((0.1, 0.2, 0.3), z=(1, 2, 2))
        law = {"density": density, "viscosity": viscosity, "wind": (0.3, 0.2, 0.1)}
        return sr.System(sr.Model("m", [body], forces=[sr.BoxDrag("drag", frame, (0.1, 0.2, 0.3), **law)]))

    assert system(100.0, 0.5).check_derivatives()
    values, names = np.array([100.0, 0.5]), ["drag.density", "drag.viscosity"]
    options = {"until": 0.3, "store": "steps", "method": sr.Radau(rtol=1e-10)}
    gradient = sr.sensitivity(sr.simulate(system(*values), **options), sr.Final("a.x"), names)
    for n, name in enumerate(names):
        step = 1e-3 * values[n] * np.eye(2)[n]
        ends = [sr.simulate(system(*(values + sign * step)), **options)["a.x"][-1] for sign in (-1, 1)]
        assert gradient[name] == pytest.approx((ends[1] - ends[0]) / (2 * step[n]), rel=1e-5)


def test_wrong_values_are_refused() -> None:
    body = sr.Body("a", 1.0, (1, 1, 1))
    with pytest.raises(sr.ModelError, match="box"):
        sr.System(sr.Model("m", [body], forces=[sr.BoxDrag("d", body.frame((0, 0, 0)), (-1, 1, 1))]))
