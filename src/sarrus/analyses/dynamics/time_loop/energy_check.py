"""A sanity check of finished runs: energy that no part supplies cannot appear, and what none dissipates not vanish."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...._jit.formulas.expression import Graph
from ....algebra import Array
from ....elements.evaluation import element_from, partition
from ....elements.force_outputs import Passive
from ....model.coordinates import WIDTH
from ....results import Trajectory
from ....system import System
from ....system.curves.curve_derivatives import curves_of
from ....system.curves.lane_drivers import local as recorded
from ....system.structure.local import GROUND, local
from ....system.structure.population import Population
from ...equations.length import extent
from ..stepping.tolerance import Tolerances

GROWTH = 0.5  # of the greatest kinetic energy: methods within their tolerances stay far below it
SLOW = 1e-6  # of the extent, and of 1 rad, within the whole time: kinetic energies of such speeds may be round-off
ROUND_OFF = 1e-9  # of the greatest potential energy, whose origin is arbitrary
ERRORS = 100.0  # times the tolerance: position errors that local ones add up to, and those between long steps


def supplies(system: System) -> bool:
    """Whether a force may supply energy, or a constraint moves."""
    moves = any(p.count and not p.is_force and p.kind.timed for p in system.populations)
    return moves or any(_supplies(system, p, k) for p, k in _forces(system))


def dissipates(system: System) -> bool:
    """Whether a force may dissipate energy."""
    return any(not _is_zero(system, p, k, "dissipated_power") for p, k in _forces(system))


def _forces(system: System) -> Iterator[tuple[Population, int]]:
    """All force elements but the weights of bodies."""
    forces = ((p, k) for p in system.populations if p.is_force for k in range(p.count))
    return ((p, k) for p, k in forces if p.owners[k] not in system.bodies)


def _element(system: System, p: Population, k: int) -> Any:
    at = p.at + k * p.kind.size()
    return element_from(p.kind, system.b[at : at + p.kind.size()], system.b)


def _state(p: Population, k: int, q: Array, v: Array, t: float) -> tuple[Any, Any, float]:
    """The coordinates of an element's bodies, their rates, and the time."""
    own = local(p, k, q, GROUND), local(p, k, v, np.zeros(WIDTH))
    return partition(p.kind, own[0]), partition(p.kind, own[1]), t


def _is_zero(system: System, p: Population, k: int, power: str) -> bool:
    """Whether a power of an element is zero whatever the state, as recorded of its formula."""
    graph, at = Graph(), p.at + k * p.kind.size()
    numbers = [graph.constant(x) for x in system.b[at : at + p.kind.size()].tolist()]
    element = element_from(p.kind, np.array(numbers, dtype=object))
    q, v = (graph.inputs(name, p.variant.moving, WIDTH) for name in ("q", "v"))
    state = recorded(p.variant, q, "q"), recorded(p.variant, v, "v"), graph.input("t")
    value = getattr(element, power)(*state) if hasattr(element, power) else None
    return bool(getattr(value, "constant", value) == 0)


def _supplies(system: System, p: Population, k: int) -> bool:
    """Whether an element may supply energy; a damper by a user's law may, too."""
    by_user = any(True for _ in curves_of(p.kind)) and not _is_zero(system, p, k, "dissipated_power")
    return by_user or not _is_zero(system, p, k, "supplied_power")


def energy_change(system: System, run: Trajectory, tolerances: Tolerances) -> list[str]:
    """A warning where energy appears or vanishes, by more than `GROWTH` of the greatest kinetic energy.

    It may appear where a part supplies energy, and vanish where one dissipates it. Changes that position errors within
    the tolerances explain, as in very stiff springs, are not reported.
    """
    kinetic, total = run.kinetic_energy, run.total_energy
    if not run.success or len(total) < 2 or any(np.any(event.v != event.after) for event in run.events):
        return []
    if not np.isfinite(total).all():  # laws may have a pole between their zero and the motion
        return []
    floor = ROUND_OFF * float(np.max(abs(run.potential_energy))) + _slow_energy(system, run)
    least = max(GROWTH * max(float(np.max(kinetic)), _between(system, run)), floor)
    if not np.ptp(total) > least or supplies(system):
        return []
    rows = [0, int(np.argmax(total)), int(np.argmin(total)), len(total) - 1]
    changes = np.array([total[row] + _of_contacts(system, run, row) for row in rows])
    changes -= changes[0]
    worst = float(changes[np.argmax(abs(changes))])
    if not abs(worst) > max(least, _energy_of_errors(system, run, tolerances)):
        return []
    if worst < 0 and dissipates(system):
        return []
    how, what = ("grew", "drives the mechanism") if worst > 0 else ("fell", "dissipates energy")
    size = f"{abs(worst):.3g} J, its kinetic part is at most {np.max(kinetic):.3g} J"
    return [
        f"{system.name}: the total energy {how} by {size}, and nothing {what}: the run is wrong. Use smaller "
        "tolerances, above all a smaller atol, or method=sr.Radau()."
    ]


def _between(system: System, run: Trajectory) -> float:
    """The kinetic energy of what accelerations add to speeds from one output to the next [J]."""
    t, q, a = (np.asarray(x) for x in (run.t, run.q, run.a))
    row = int(np.argmax(np.linalg.norm(a, axis=1)))
    return system.kinetic_energy(q[row], a[row] * np.diff(t).max())


def _of_contacts(system: System, run: Trajectory, row: int) -> float:
    """The energy that contacts store at one state, which is in no potential [J]."""
    t, q, v, memory = (np.asarray(x)[row] for x in (run.t, run.q, run.v, run.memory))
    system = system.with_memory(memory)
    own = [
        (p, k) for p, k in _forces(system) if issubclass(p.kind, Passive) and not hasattr(p.kind, "potential")
    ]
    return float(sum(_element(system, p, k).stored_energy(*_state(p, k, q, v, float(t))) for p, k in own))


def _energy_of_errors(system: System, run: Trajectory, tolerances: Tolerances) -> float:
    """|Q|ᵀe + ½ eᵀ|Q_q|e at the last state, with position errors e of `ERRORS` times the tolerances [J]."""
    t, q, v, memory = (np.asarray(x)[-1] for x in (run.t, run.q, run.v, run.memory))
    system = system.with_memory(memory)
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
