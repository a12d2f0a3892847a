"""Sensors of an MJCF model that are positions, velocities and accelerations of frames and joints."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np

from ...model.geometry.pose import GROUND_POSE, Pose
from ..robot import Sensor
from ..robot.interaction import TOUCH
from ..robot.sensors import KINDS
from ..robot.zone import zone
from .bodies import BALL, placed
from .compiled import Object, mujoco, name_of


def sensors_of(compiled: Any) -> dict[str, Sensor]:
    """Return the supported sensors by name."""
    sensors = {name_of(compiled, "sensor", k): _sensor(compiled, k) for k in range(compiled.nsensor)}
    return {name: sensor for name, sensor in sensors.items() if sensor is not None}


def unused(compiled: Any, supported: Collection[str]) -> tuple[int, int]:
    """Return how many of the supported sensors have noise, and how many a delay or an interval between values."""
    used = [k for k in range(compiled.nsensor) if name_of(compiled, "sensor", k) in supported]
    arrays = [getattr(compiled, f"sensor_{word}", None) for word in ("delay", "interval")]
    delayed = sum(any(array is not None and np.any(array[k]) for array in arrays) for k in used)
    return int(np.count_nonzero(compiled.sensor_noise[used])), delayed


def _sensor(compiled: Any, k: int) -> Sensor | None:
    kind = mujoco().mjtSensor(int(compiled.sensor_type[k])).name.removeprefix("mjSENS_").lower()
    place, what = int(compiled.sensor_objid[k]), int(compiled.sensor_objtype[k])
    if kind not in KINDS or compiled.sensor_refid[k] >= 0 or compiled.sensor_cutoff[k] > 0:
        return None
    if what == Object.JOINT:
        start = float(compiled.qpos0[compiled.jnt_qposadr[place]])
        one_number = compiled.jnt_type[place] > BALL
        return Sensor(kind, joint=name_of(compiled, "joint", place), start=start) if one_number else None
    frame = _frame(compiled, what, place)
    if kind == TOUCH:
        shape = mujoco().mjtGeom(int(compiled.site_type[place])).name.removeprefix("mjGEOM_").lower()
        there = zone(shape, compiled.site_size[place])
        return frame and Sensor(kind, link=frame[0], point=frame[1].r, axes=frame[1].A, zone=there)
    return Sensor(kind, link=frame[0], point=frame[1].r, axes=frame[1].A) if frame else None


def _frame(compiled: Any, what: int, place: int) -> tuple[str, Pose] | None:
    """Return the link of a frame and its pose on it."""
    if what in (Object.XBODY, Object.BODY):
        inertial = placed(compiled.body_ipos[place], compiled.body_iquat[place])
        return name_of(compiled, "body", place), inertial if what == Object.BODY else GROUND_POSE
    if what not in (Object.GEOM, Object.SITE):
        return None
    word = "geom" if what == Object.GEOM else "site"
    body, r, p = (getattr(compiled, f"{word}_{field}")[place] for field in ("bodyid", "pos", "quat"))
    return name_of(compiled, "body", body), placed(r, p)
