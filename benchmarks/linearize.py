"""Linearization and forward dynamics of a chain of seven joints, and of the robot Talos: processor time of a call.

    python -m benchmarks.linearize

Talos needs the package example-robot-data, of the extra `robots`. The least of several batches.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path

import numpy as np

import sarrus as sr

BATCHES, CALLS, JOINTS = 10, 30, 7
TALOS = "cmeel.prefix/share/example-robot-data/robots/talos_data/robots/talos_reduced.urdf"


def least(call: Callable[[], object]) -> float:
    """The least processor time of a call [µs]."""
    call()
    found = []
    for _ in range(BATCHES):
        began = time.process_time()
        for _ in range(CALLS):
            call()
        found.append((time.process_time() - began) / CALLS)
    return 1e6 * min(found)


def arm() -> sr.System:
    """A chain of seven joints with crossed axes."""
    bodies, joints, last = [], [], sr.ground
    for n in range(JOINTS):
        x, z = 0.02 * n, 0.3 * n
        link = sr.Body(f"link{n}", mass=2.0 + 0.1 * n, inertia=(0.02, 0.03, 0.01), position=(x, 0, z + 0.15))
        axis = (0, 0, 1) if n % 2 == 0 else (0, 1, 0)
        joints.append(sr.Revolute(f"joint{n}", last, link, point=(x, 0, z), axis=axis))
        bodies.append(link)
        last = link
    return sr.System(sr.Model("arm", bodies, joints, gravity=(0, 0, -9.81)))


def systems() -> Iterator[sr.System]:
    """The systems that can be built here."""
    yield arm()
    spec = find_spec("numpy")
    file = Path(spec.origin).parents[1] / TALOS if spec and spec.origin else Path(TALOS)
    if file.exists():
        yield sr.System(sr.load_urdf(file, base="floating", meshes="ignore"))


def main() -> None:
    """Measure at rest and in motion, with named coordinates and with chosen ones."""
    for system in systems():
        q, v = system.q0, np.zeros(system.nq)
        states = sr.linearize(system, q, v).states
        names = list(states[: len(states) // 2])
        moving = sr.assemble(
            system, q, rates={name: 0.3 for name in names if name in system.joint_coordinates.names}
        ).v
        times = [
            least(lambda q=q, x=x, names=names, s=system: sr.linearize(s, q, x, coordinates=names))
            for x in (v, moving)
        ]
        chosen = least(lambda q=q, v=v, s=system: sr.linearize(s, q, v))
        print(
            f"{system.name}, {len(names)} degrees of freedom: {times[0]:.0f} µs at rest, {times[1]:.0f} µs in motion,"
        )
        print(f"    {chosen:.0f} µs with coordinates that are chosen")
        f = system.forward_dynamics
        parts = [least(lambda f=f, q=q, v=v, one=one: one(q, v)) for one in (f, f.derivatives)]
        print(f"    forward dynamics {parts[0]:.1f} µs, with derivatives {parts[1]:.1f} µs")


if __name__ == "__main__":
    main()
