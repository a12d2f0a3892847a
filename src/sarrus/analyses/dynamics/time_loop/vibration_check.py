"""Detection of fast vibrations, invisible in the outputs, in runs with very many steps."""

from __future__ import annotations

import numpy as np

from ....algebra import Array
from ....elements.evaluation import dense, element_from
from ....elements.operators import OPERATORS
from ....model.coordinates import WIDTH
from ....results import State, Trajectory
from ....system import System

MANY = 20_000  # steps: fewer take little time
GROUND = np.array([0.0, 0, 0, 1, 0, 0, 0])  # coordinates of the ground
EACH = 20  # steps for each output
OUTPUTS = 100  # so many at least, or the motion between them is not known
LOOKED_AT = 10_000  # the last outputs, of which statistics are made: a saved run may not fit into memory
FAST = 5.0  # what accelerations would change velocities by between two outputs, over what they change by
STRONG = 1e-2  # of the greatest acceleration of its kind: weaker ones may be round-off
RESOLVED = (0.01, 2.0)  # ω h of steps that a vibration forces upon the error control


def fast_vibration(run: Trajectory, advice: str) -> list[str]:
    """A warning where a vibration of several periods between two outputs forced the steps of a finished run.

    Its circular frequency is that of accelerations over velocities, of which only the change from output to output is
    counted: a sampled vibration changes by √2 of its size, the motion itself hardly.
    """
    if not run.success or run.nsteps < max(MANY, EACH * len(run.t)) or len(run.t) < OUTPUTS:
        return []
    last = slice(-LOOKED_AT, None)
    acceleration = _root_mean_square(run.a[last])
    change = _root_mean_square(np.diff(run.v[last], axis=0)) / np.sqrt(2)
    interval, step = float(np.median(np.diff(run.t))), float(run.t[-1] - run.t[0]) / run.nsteps
    kinds = np.arange(WIDTH * len(run.bodies)).reshape(-1, WIDTH)
    strong = np.zeros(acceleration.size, dtype=bool)
    for columns in (kinds[:, :3].ravel(), kinds[:, 3:].ravel()):
        strong[columns] = acceleration[columns] > STRONG * acceleration[columns].max(initial=0.0)
    omega = np.where(strong & (change > 0), acceleration / np.where(change > 0, change, 1.0), 0.0)
    worst = int(np.argmax(omega))
    if omega[worst] * interval < FAST or not RESOLVED[0] < omega[worst] * step < RESOLVED[1]:
        return []
    cause = _cause(run, worst)
    if not cause and run.system is not None and worst % WIDTH >= 3:  # no stiffness: the body spins
        return []
    return [
        f"{run.name}: a vibration of {run.coordinate_names[worst]} at some {omega[worst] / (2 * np.pi):.0e} Hz, which "
        f"the outputs do not resolve, forced {run.nsteps} steps{cause}. {advice}"
    ]


def _cause(run: Trajectory, place: int) -> str:
    """Return the stiffest force on a coordinate, for a message."""
    if run.system is None or run.final is None:
        return ""
    found = stiffnesses(run.system, run.final, place)
    name = max(found, key=found.__getitem__, default="")
    return f"; the stiffest force on it is {name}" if name and found[name] > 0 else ""


def stiffnesses(system: System, state: State, place: int) -> dict[str, float]:
    """|∂Q_k/∂q_k| of each force for one coordinate q_k, by the name of the force. [N/m], of Euler parameters [N m]"""
    found: dict[str, float] = {}
    for p in system.populations:
        for k, owner in enumerate(p.owners if p.is_force else ()):
            firsts = [-1 if slot < 0 else int(p.bodies[k, slot]) for slot in p.variant.slots]
            bodies = [first // 7 for first in firsts]
            if place // 7 in bodies:
                own = 7 * bodies.index(place // 7) + place % 7
                at = p.at + k * p.kind.size()
                element = element_from(p.kind, system.b[at : at + p.kind.size()], system.b, state.t)
                q, v = (
                    np.concatenate([ground if first < 0 else y[first : first + 7] for first in firsts])
                    for y, ground in ((state.q, GROUND), (state.v, 0 * GROUND))
                )
                Q_q = dense(element, OPERATORS["Q_q"], {"q": q, "v": v, "t": state.t})
                found[owner] = found.get(owner, 0.0) + abs(float(Q_q[own, own]))
    return found


def _root_mean_square(x: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(x * x, axis=0)))
