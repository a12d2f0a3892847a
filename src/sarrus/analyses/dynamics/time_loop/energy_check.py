"""A sanity check of finished runs: the energy of a mechanism that nothing drives cannot grow."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....elements.forces.bushing import Bushing
from ....elements.forces.drag import ViscousDrag
from ....elements.forces.gravity import EccentricGravity, Gravity
from ....elements.forces.joint_friction import AngleFriction, DisplacementFriction
from ....elements.forces.rsda import RSDA, NonlinearRSDA
from ....elements.forces.tsda import TSDA, NonlinearTSDA
from ....results import Trajectory
from ....system import System
from ...equations.length import extent
from ..stepping.tolerance import Tolerances

GROWTH = 0.5  # of the greatest kinetic energy: methods within their tolerances stay far below it
SLOW = 1e-6  # of the extent, and of 1 rad, within the whole time: kinetic energies of such speeds may be round-off
ROUND_OFF = 1e-9  # of the greatest potential energy, whose origin is arbitrary
ERRORS = 100.0  # times the tolerance: position errors that local ones add up to, and those between long steps
LAWS = {NonlinearTSDA, NonlinearRSDA}  # springs and dampers given by curves
PASSIVE = {
    Gravity,
    EccentricGravity,
    TSDA,
    RSDA,
    Bushing,
    ViscousDrag,
    AngleFriction,
    DisplacementFriction,
    *LAWS,
}
ACTUATED = ("force", "torque")  # fields of springs that put in work
DAMPER = "c"  # of springs: a curve of it may put in work, too


def is_passive(system: System) -> bool:
    """Whether all forces keep or dissipate the energy that `Trajectory.total_energy` has, and no constraint moves."""
    return all(_passive(p) for p in system.populations if p.count)


def _passive(population: Any) -> bool:
    kind = population.kind
    if not population.is_force:
        return not kind.timed
    names = list(kind.fields)
    working = (*ACTUATED, DAMPER) if kind in LAWS else ACTUATED
    return kind in PASSIVE and not any(
        values[names.index(name)] for name in working if name in names for values in population.values
    )


def energy_growth(system: System, run: Trajectory, tolerances: Tolerances) -> list[str]:
    """A warning where the energy of a passive mechanism grew by more than `GROWTH` of its kinetic energy.

    Growth that position errors within the tolerances explain, as in very stiff springs, is not reported.
    """
    kinetic, total = run.kinetic_energy, run.total_energy
    if not run.success or len(total) < 2 or any(np.any(event.v != event.after) for event in run.events):
        return []
    if not np.isfinite(total).all():  # laws may have a pole between their zero and the motion
        return []
    grown = float(np.max(total) - total[0])
    floor = ROUND_OFF * float(np.max(abs(run.potential_energy))) + _slow_energy(system, run)
    if not grown > max(GROWTH * float(np.max(kinetic)), floor) or not is_passive(system):
        return []
    if grown <= _energy_of_errors(system, run, tolerances):
        return []
    return [
        f"{system.name}: the total energy grew by {grown:.3g} J, its kinetic part is at most {np.max(kinetic):.3g} J, "
        "and nothing drives the mechanism: the run is wrong. Use smaller tolerances, above all a smaller atol, or "
        "method=sr.Radau()."
    ]


def _energy_of_errors(system: System, run: Trajectory, tolerances: Tolerances) -> float:
    """|Q|ᵀe + ½ eᵀ|Q_q|e at the last state, with position errors e of `ERRORS` times the tolerances [J]."""
    t, q, v = (np.asarray(x)[-1] for x in (run.t, run.q, run.v))
    error = ERRORS * tolerances.of_motion(np.asarray(run.q))
    stiffness = abs(system.Q_q(q, v, t))
    return float(abs(system.Q(q, v, t)) @ error + 0.5 * error @ (stiffness @ error))


def _slow_energy(system: System, run: Trajectory) -> float:
    """The kinetic energy of bodies that move and rotate with the speed `SLOW` [J]."""
    found, length = 0.0, extent(system, np.asarray(run.q)[0])
    for p in system.populations:
        names = list(p.kind.fields)
        if p.count and "inertia" in names and "mass" in names:
            mass, tensor = names.index("mass"), names.index("inertia")
            found += sum(length**2 * float(v[mass]) + float(np.sum(v[tensor][:3])) for v in p.values)
    return 0.5 * (SLOW / float(run.t[-1] - run.t[0])) ** 2 * found
