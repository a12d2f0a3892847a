"""Sensors of MJCF are outputs, against MuJoCo's values in a random state."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.needs("mujoco")

FRAMES = ("framepos", "framequat", "framexaxis", "frameyaxis", "framezaxis", "framelinvel", "frameangvel")
ACCELERATIONS = ("framelinacc", "frameangacc")
OBJECTS = {"site": "s", "xbody": "b", "body": "b", "geom": "g"}
OF_SITES = ("velocimeter", "gyro", "accelerometer")
FILE = """<mujoco><compiler angle="radian"/><worldbody><site name="w"/>
  <body name="a" euler="1 2 3"><joint name="x" axis="1 2 3" ref="0.2"/>
    <geom type="box" size="0.1 0.2 0.3" pos="0.1 0 1"/>
    <body name="b" pos="0 0 2" euler="50 0 10"><joint name="y" type="slide" axis="1 1 0" ref="0.1"/>
      <geom name="g" type="box" size="0.1 0.2 0.3" pos="0.1 0.2 1" euler="0.1 0.2 0.3"/>
      <body name="fixed" pos="0 1 0" euler="0.3 0.1 0.2"><site name="s" pos="0.3 0 0.5" euler="0.1 0.2 0.3"/></body>
    </body></body></worldbody><sensor>{sensors}</sensor>
  <keyframe><key name="k" qpos="0.7 -0.3" qvel="1.2 -0.8"/></keyframe></mujoco>
"""


def test_sensors_are_outputs(tmp_path: Path) -> None:
    path, entries = tmp_path / "model.xml", []
    for word in (*FRAMES, *ACCELERATIONS):
        for kind, name in OBJECTS.items():
            entries.append(f'<{word} name="{word}_{kind}" objtype="{kind}" objname="{name}"/>')
    entries += [f'<{word} name="{word}_s" site="s"/>' for word in OF_SITES]
    entries += [
        f'<{word} name="{word}_{one}" joint="{one}"/>' for word in ("jointpos", "jointvel") for one in "xy"
    ]
    path.write_text(FILE.format(sensors="".join(entries)))
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    robot = sr.load_mjcf(path, ignore=["contacts"])
    assert len(robot.sensors) == model.nsensor
    run = sr.simulate(sr.System(robot), robot.start("k"), until=0.01, store="steps")
    for k in range(model.nsensor):
        first, width = int(model.sensor_adr[k]), int(model.sensor_dim[k])
        expected, name = data.sensordata[first : first + width], model.sensor(k).name
        axes = {1: ("",), 3: (".x", ".y", ".z"), 4: (".e0", ".e1", ".e2", ".e3")}[width]
        found = np.array([run[name + axis][0] for axis in axes])
        if width == 4 and found @ expected < 0:
            found = -found
        np.testing.assert_allclose(found, expected, atol=1e-8, err_msg=name)
    gradient = sr.sensitivity(run, sr.Final("accelerometer_s.x"), ["b.mass"])
    assert np.isfinite(gradient["b.mass"])


def test_other_sensors_are_noted(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(
        FILE.format(sensors='<magnetometer site="s"/><gyro site="w"/><jointpos joint="x" cutoff="1"/>')
    )
    notes = sr.load_mjcf(path, ignore=["contacts"]).notes
    assert any("2 sensors of other kinds, relative to a frame, or with a cutoff" in note for note in notes)
    assert any("1 sensor on the ground" in note for note in notes)


def test_noise_and_delay_are_noted(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    words = ('noise="0.1"', 'delay="0.1" nsample="100"', 'interval="0.1"', "", 'cutoff="1" noise="0.1"')
    path.write_text(FILE.format(sensors="".join(f'<jointpos joint="x" {one}/>' for one in words)))
    robot = sr.load_mjcf(path, ignore=["contacts"])
    assert len(robot.sensors) == 4
    assert any(note.startswith("1 noise of sensors") for note in robot.notes)
    assert any(note.startswith("2 delays and intervals of sensors") for note in robot.notes)


LOADED = """<mujoco><compiler angle="radian"/><option gravity="1 2 -9"/><worldbody>
  <body name="a" euler="1 2 3"><joint name="x" axis="1 2 3" ref="0.2" damping="0.3" armature="0.1" stiffness="2"/>
    <site name="s_a" pos="0.1 0.2 0.3" euler="0.3 0.2 0.1"/><geom type="box" size="0.1 0.2 0.3" pos="0.1 0 1"/>
    <body name="b" pos="0 0 2" euler="50 0 10" gravcomp="0.5"><joint name="y" type="slide" axis="1 1 0" damping="0.2"/>
      <geom name="g" type="box" size="0.1 0.2 0.3" pos="0.1 0.2 1" euler="0.1 0.2 0.3"/>
      <body name="fixed" pos="0 1 0" euler="0.3 0.1 0.2"><site name="s_fixed" pos="0.3 0 0.5" euler="0.1 0.2 0.3"/>
        <geom type="box" size="0.1 0.1 0.2" pos="0.2 0 0"/>
        <body name="c" pos="0.4 0.3 0"><joint name="z" axis="0 1 2"/><site name="s_c"/>
          <geom type="capsule" size="0.1 0.2" pos="0 0 0.3"/></body></body>
    </body></body></worldbody>
  <actuator><motor name="m" joint="z" gear="0.7"/></actuator><sensor>{sensors}</sensor>
  <keyframe><key name="k" qpos="0.7 -0.3 0.4" qvel="1.2 -0.8 2.1"/></keyframe></mujoco>
"""


@pytest.mark.slow
def test_forces_between_a_link_and_its_parent(tmp_path: Path) -> None:
    """At joints, and of a link that is fixed to its parent; with all that hangs on it."""
    path = tmp_path / "model.xml"
    ends = [f"{kind}_{site}" for kind in ("force", "torque") for site in ("s_a", "s_fixed", "s_c")]
    path.write_text(
        LOADED.format(
            sensors="".join(f'<{e.partition("_")[0]} name="{e}" site="{e.partition("_")[2]}"/>' for e in ends)
        )
    )
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    data.ctrl[0] = 1.5
    mujoco.mj_forward(model, data)
    robot = sr.load_mjcf(path, ignore=["contacts"], controls={"m": 1.5})
    run = sr.simulate(sr.System(robot), robot.start("k"), until=0.01, store="steps")
    for k, name in enumerate(ends):
        found = [run[f"{name}.{axis}"][0] for axis in "xyz"]
        expected = data.sensordata[3 * k : 3 * k + 3]
        np.testing.assert_allclose(found, expected, atol=1e-9 * abs(expected).max(), err_msg=name)

    def run_with(mass: float) -> float:
        changed = sr.load_mjcf(path, ignore=["contacts"], controls={"m": 1.5})
        heavier = [replace(body, mass=mass) if body.name == "c" else body for body in changed.bodies]
        return float(
            sr.simulate(sr.System(replace(changed, bodies=tuple(heavier))), changed.start("k"), until=0.01)[
                "force_s_c.x"
            ][-1]
        )

    gradient = sr.sensitivity(run, sr.Final("force_s_c.x"), ["c.mass"])
    mass = next(body.mass for body in robot.bodies if body.name == "c")
    difference = (run_with(mass + 1e-3) - run_with(mass - 1e-3)) / 2e-3
    assert gradient["c.mass"] == pytest.approx(difference, rel=1e-4)


RESTING = """<mujoco><option timestep="0.001"/><worldbody><geom type="plane" size="1 1 1" euler="0 10 0"/>
  <body name="a" pos="0 0 0.1"><joint type="slide" axis="0 0 1"/>{joint}
    <inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/>
    <geom type="sphere" size="0.1" contype="{contype}" conaffinity="{contype}"
      solimp="0.9 0.9 0.001" friction="0 0 0"/>
    <site name="s" size="0.05" pos="{place}"/>{zones}</body></worldbody>
  <equality>{loop}</equality>
  <sensor><force name="f" site="s"/><touch name="t" site="s"/>{touches}</sensor></mujoco>
"""
ZONE = '<site name="{}{}" type="{}" size="{}" pos="{}" euler="{}"/>'
LOADS = {
    "contact": (1, "0 0 -0.09", ""),
    "contact beside the zone": (1, "0.09 0 0", ""),
    "contact towards the zone": (1, "-0.0347 0 -0.197", ""),
    "loop": (0, "0 0 0", '<connect body1="a" anchor="0 0 0"/>'),
}


@pytest.mark.parametrize("case", LOADS)
def test_contacts_and_loops_are_no_forces_of_the_joint(case: str, tmp_path: Path) -> None:
    contype, place, loop = LOADS[case]
    path = tmp_path / "model.xml"
    path.write_text(
        RESTING.format(
            contype=contype,
            place=place,
            loop=loop,
            joint="" if contype else '<joint axis="0 0 1" damping="1"/>',
            zones="",
            touches="",
        )
    )
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    for _ in range(3000):
        mujoco.mj_step(model, data)
    robot = sr.load_mjcf(path)
    system = sr.System(robot)
    run = sr.simulate(system, until=3.0)
    found = [run[f"f.{axis}"][-1] for axis in "xyz"]
    np.testing.assert_allclose(found, data.sensordata[:3], atol=1e-4 * 2 * 9.81)
    if contype:
        assert run["t"][-1] == pytest.approx(data.sensordata[3], rel=1e-4, abs=1e-9)
        assert bool(data.sensordata[3]) == (case != "contact beside the zone")
    else:
        assert "1 touch sensor of a body without contacts: left out" in robot.notes


def test_touch_sensors_have_zones_of_all_shapes(tmp_path: Path) -> None:
    """Random zones of each shape near a contact: each is met where MuJoCo's ray meets it."""
    shapes, rng = ("sphere", "capsule", "ellipsoid", "cylinder", "box"), np.random.default_rng(3)
    zones, touches = "", ""
    for shape in shapes:
        for n in range(60 if shape == "capsule" else 20):
            size, place, turn = rng.uniform(0.02, 0.1, 3), 0.05 * rng.normal(size=3), rng.normal(size=3)
            words = (" ".join(map(str, three)) for three in (size, place - (0, 0, 0.15), turn))
            zones += ZONE.format(shape, n, shape, *words)
            touches += f'<touch name="t{shape}{n}" site="{shape}{n}"/>'
    path = tmp_path / "model.xml"
    path.write_text(
        RESTING.format(contype=1, place="0 0 -0.09", loop="", joint="", zones=zones, touches=touches)
    )
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=3000)
    robot = sr.load_mjcf(path)
    run = sr.simulate(sr.System(robot), until=3.0)
    for shape in shapes:
        names = [name for name in robot.sensors if name.startswith(f"t{shape}")]
        expected = np.array([data.sensor(name).data[0] for name in names])
        found = np.array([run[name][-1] for name in names])
        np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-9)
        assert 3 < np.count_nonzero(expected) < len(names) - 3
