"""Sensors of MJCF are outputs, against MuJoCo's values in a random state."""

from pathlib import Path

import numpy as np
import pytest

import sarrus as sr

mujoco = pytest.importorskip("mujoco")

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
    run = sr.simulate(sr.System(robot), robot.start("k"), until=0.01, store_steps=True)
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
    path.write_text(FILE.format(sensors='<touch site="s"/><gyro site="w"/><jointpos joint="x" cutoff="1"/>'))
    notes = sr.load_mjcf(path, ignore=["contacts"]).notes
    assert any("2 sensors of other kinds, relative to a frame, or with a cutoff" in note for note in notes)
    assert any("1 sensors on the ground" in note for note in notes)


def test_noise_and_delay_are_noted(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    words = ('noise="0.1"', 'delay="0.1" nsample="100"', 'interval="0.1"', "", 'cutoff="1" noise="0.1"')
    path.write_text(FILE.format(sensors="".join(f'<jointpos joint="x" {one}/>' for one in words)))
    robot = sr.load_mjcf(path, ignore=["contacts"])
    assert len(robot.sensors) == 4
    assert any(note.startswith("1 noises of sensors") for note in robot.notes)
    assert any(note.startswith("2 delays and intervals of sensors") for note in robot.notes)
