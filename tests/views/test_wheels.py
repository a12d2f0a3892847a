"""Wheels whose spins are states turn in pages, films and files, by the integral of the spin less the carrier's."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
from sarrus.euler import A
from sarrus.model.geometry.motion import axis_angle
from sarrus.model.geometry.rotation import product
from sarrus.views.looks import sketch

Y, Z = np.eye(3)[1:]
CENTRE = np.array([0.02, 0.1, -0.03])
SPIN, PITCH, YAW = 40.0, 3.0, 2.0  # [rad/s]


def system() -> sr.System:
    """A carrier in flight, whose wheel spins."""
    body = sr.Body("carrier", mass=20.0, inertia=(1, 1, 1), position=(0, 0, 5.0), velocity=(4, 0, 0))
    law = {"k": 2e4, "c_kappa": 2e4, "c_alpha": 2e4, "mu": 1.0, "radius": 0.3}
    tyre = sr.BrushTyre("tyre", body.point(*CENTRE), **law, spin_inertia=0.5, initial_spin=SPIN)
    return sr.System(sr.Model("flight", [body], [], [tyre]))


def turns(axis: np.ndarray, rate: float, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Euler parameters and their rates of a rotation about an axis (n, 4)."""
    half = rate * t[:, None] / 2
    p = np.array([axis_angle(axis, float(2 * a)) for a in half[:, 0]])
    return p, rate / 2 * np.column_stack([-np.sin(half), np.cos(half) * axis])


@pytest.mark.parametrize("axis", [Y, Z], ids=["pitch", "yaw"])
def test_the_frame_of_a_wheel_turns_by_its_spin(axis: np.ndarray) -> None:
    """The spin is absolute: about its own axis the wheel does not turn with its carrier, across it does."""
    flying, t = system(), np.linspace(0.0, 0.5, 51)
    place = flying.states["tyre.spin"].place
    q, v = np.tile(flying.q0, (51, 1)), np.tile(flying.v0, (51, 1))
    q[:, place] = SPIN * t
    q[:, 3:7], v[:, 3:7] = turns(axis, PITCH if axis is Y else YAW, t)
    drawn = sketch(flying.model)
    frames = drawn.coordinates(t, q, v)[:, 7:]
    wheel, _ = turns(Y, SPIN, t)
    expected = wheel if axis is Y else [product(p, s) for p, s in zip(q[:, 3:7], wheel, strict=True)]
    for frame, carrier, p in zip(frames, q, expected, strict=True):
        assert frame[:3] == pytest.approx(carrier[:3] + A(carrier[3:7]) @ CENTRE)
        assert A(frame[3:]) == pytest.approx(A(np.asarray(p)), abs=1e-9)
    assert {part.body for part in drawn.parts if part.name == "tyre"} == {2}


def test_the_wheel_of_a_run_turns_in_a_file(tmp_path: Path) -> None:
    run = sr.simulate(system(), until=0.05, t_eval=[0.0, 0.05])
    data = sr.animate(run, tmp_path / "flight.glb", count=3).read_bytes()
    size = int.from_bytes(data[12:16], "little")
    scene, numbers = json.loads(data[20 : 20 + size]), data[28 + size :]
    (node,) = (n for n, one in enumerate(scene["nodes"]) if one["name"] == "tyre" and "mesh" not in one)
    channels, samplers = (scene["animations"][0][key] for key in ("channels", "samplers"))
    (turning,) = (
        samplers[one["sampler"]]["output"]
        for one in channels
        if one["target"] == {"node": node, "path": "rotation"}
    )
    start = scene["bufferViews"][scene["accessors"][turning]["bufferView"]]["byteOffset"]
    last = np.frombuffer(numbers, "<f4", 12, start)[8:]
    assert last == pytest.approx([0, np.sin(SPIN * 0.05 / 2), 0, np.cos(SPIN * 0.05 / 2)], abs=1e-5)
