"""Assembly: the nearest coordinates and velocities that satisfy the constraints."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...euler import A
from ...linalg.rank import rank_of
from ...linalg.threads import one_thread_if_small
from ...model.announcement import announce, reports_warnings
from ...model.errors import listed
from ...model.geometry.points import GROUND
from ...model.geometry.pose import GROUND_POSE, Pose, Poses
from ...model.joints.pairs import Fixed
from ...results import Assembly, AssemblyRequest
from ...system import System
from ..arguments import kind, refuse_other_system
from ..equations.length import extent, lever, scaled, units
from ..equations.projection import allowed
from ..equations.projection import metric as metric_of
from .assembly_changes import position_changes, velocity_changes, warning
from .joint_space import followed_coordinates, held_coordinates
from .least_change import FeasibleSearch, LeastChange, Renormalization, SearchEnd
from .prescribed_angles import prescribed_memory, prescribed_revolutions, with_leaders
from .restraint import restraint
from .velocity import FREE, Rates, assemble_velocity, given_velocities

# Of the size of the system (in r) and of 1 (in p): changes of the estimate in two restarts each
SHAKES = (0.05, 0.1, 0.2, 0.3, 0.5)
PART = 1e-3  # of the largest gap, below which a joint is not worth a word


def open_joints(
    system: System, q: Array, residual: Array, allowed: Array, t: float, per_second: bool = False
) -> str:
    """For example "post by 0.02 m, hinge by 0.013 rad"; the widest gap first, nothing if all are closed.

    Parameters
    ----------
    system : System
    q : (nq,)
    residual : (m,) Φ, or Φ_q v + Φ_t for gaps that open `per_second`
    allowed : (m,) equations that hold so well are closed
    t : time [s]
    """
    J, gaps_of_joints = system.Phi_q(q, t), []
    for joint, rows in system.rows.items():
        gaps: dict[str, float] = {}
        for row in rows[abs(residual[rows]) > allowed[rows]]:
            there = restraint(system.layout, J, int(row), q)
            xi = there.displacement(system.nq)
            curvature = 0.0 if per_second else float((system.Phi_q_xi_q(q, xi, t) @ xi)[row])
            gap = there.gap(float(residual[row]), curvature)
            gaps[there.unit] = float(np.hypot(gaps.get(there.unit, 0.0), gap))
        gaps_of_joints += [(gap, joint, unit) for unit, gap in gaps.items()]
    return _words(sorted(gaps_of_joints, reverse=True), "/s" if per_second else "")


def _words(gaps: list[tuple[float, str, str]], rate: str) -> str:
    wide = [gap for gap in gaps if gap[0] > PART * gaps[0][0]]
    return listed([f"{joint} by {gap:.3g} {unit}{rate}" for gap, joint, unit in wide])


def turned_over(system: System, q: Array) -> Iterator[str]:
    """Yield one message for each fixed joint whose frames differ by half a revolution: right angles hold there, too."""
    fixed = [joint for joint in system.model.joints if isinstance(joint, Fixed)]
    if not fixed:
        return
    drawn, assembled = system.model.design_poses(), _poses(system, q)
    for joint in fixed:
        i, j = joint.frames(drawn)
        axes = zip((i.f, i.g, i.h), (j.f, j.g, j.h), strict=True)
        if any((assembled[i.body].A @ a) @ (assembled[j.body].A @ b) < 0.0 for a, b in axes):
            yield (
                f"{joint.name}: {j.body} is turned over by 180 deg relative to {i.body}, which satisfies the "
                "equations of a fixed joint, too. Start the assembly from a nearer position."
            )


def _poses(system: System, q: Array) -> Poses:
    places = zip(system.bodies, q[system.layout.positions], q[system.layout.bodies.rotations], strict=True)
    poses = {name: Pose(r, p, A(p)) for name, r, p in places}
    return {GROUND: GROUND_POSE, **poses}


@reports_warnings
@one_thread_if_small
def assemble(
    system: System,
    q: ArrayLike | None = None,
    v: ArrayLike | None = None,
    *,
    t: float = 0.0,
    fixed: Iterable[str] = (),
    rates: Mapping[str, float] | None = None,
    metric: str | ArrayLike = "unit",
    tolerance: float = 1e-12,
    iterations: int = 200,
    restarts: int = 16,
    seed: int = 0,
) -> Assembly:
    """Compute coordinates and velocities that satisfy the constraints, close to an initial estimate.

    First, a damped Gauss-Newton search from the estimate finds a position with Φ = 0. If it does not converge, it is
    restarted from a randomly changed estimate. Then Newton's method finds the nearest position,
    q = argmin ½ (q - q₀)ᵀ W (q - q₀) with Φ(q) = 0. Velocities follow: argmin ½ (v - v₀)ᵀ W (v - v₀) with
    Φ_q v = -Φ_t and the given rates. Velocities that the model gives, and those of `v` that differ from the model's,
    hold, and the others follow from them, with weights of 3e-10. Redundant constraints are allowed if they do not
    contradict each other.

    The estimate selects the assembly mode: a four-bar drawn crossed is assembled crossed. Driven angles, those of gears
    connected to them, and springs about their axes have the revolutions of the driver's motion at the time t.

    The attribute ``changes`` lists visible changes: of positions by more than 1e-3 of the mechanism's size, of
    orientations by more than 1e-3 rad, and of given velocities by a relative change of more than 1e-3. Changes of the
    model's initial state, or of given velocities, are warnings; a given `q` is an estimate.

    Parameters
    ----------
    system : System
    q, v : (nq,) the estimate; by default the model's initial state. Euler parameters may have any length except zero.
    t : time [s]
    fixed : names of bodies (``"frame"``) and coordinates (``"slider.x"``, ``"crank.e0"``) that keep their q and v
    rates : given velocities, in addition to the model's initial rates, which apply if `v` is not given: of
        coordinates [m/s, 1/s], or of angles [rad/s] and displacements [m/s] of joints, ``"pin"`` if the joint has
        only one, else ``"sleeve.displacement"``, ``"hook.angle_i"``; texts have units, ``"90 deg/s"``
    metric : the diagonal of W. "unit": 1 rad counts like a displacement by the root mean square of the model's
        dimensions, which are distances of joint points and ends of springs from the origins of their bodies, radii of
        rolling bodies, and distances of these origins, and of points on the ground, from their mean. "mass": masses and
        moments of inertia. Or (nq,) positive weights of the coordinates. Derivatives take "unit" as a function of the
        parameters and of the estimate, the others as constants
    tolerance : of |Φ|, of each equation relative to its gradient: a displacement in parts of the largest lever arm of
        the joints, or a rotation [rad]; round-off of coordinates far from the origin is allowed
    iterations : largest number of steps of one search
    restarts : largest number of further searches
    seed : of the random changes of the estimate

    Returns
    -------
    Assembly
        With ``success`` false and the open joints in ``message`` if the constraints could not be satisfied.

    Raises
    ------
    KeyError
        If `fixed` or `rates` contain unknown names.
    ValueError
        For wrong shapes or a metric that is not positive.
    """
    refuse_other_system(system, "assemble")
    held, followed = held_coordinates(system, fixed), followed_coordinates(system)
    estimate = _vector("q", system.q0 if q is None else q, system.nq)
    weight = metric_of(system, metric, estimate)
    inverse = np.where(held | followed, 0.0, 1 / weight)
    guess = Renormalization(system.layout, inverse)(estimate)
    speed = _vector("v", system.v0 if v is None else v, system.nq)
    rates = {**(system.model.rates if v is None else {}), **(rates or {})}
    given_rates = Rates(system, rates)
    request = AssemblyRequest(
        guess,
        speed,
        weight,
        weight * np.where(given_velocities(system, speed), 1.0, FREE),
        held,
        followed,
        dict(zip(rates, given_rates.values.tolist(), strict=True)),
        float(t),
        isinstance(metric, str) and metric == "unit",
    )
    memory = prescribed_memory(system, request.t, system.b)
    nominal, system = system, system.with_memory(memory)
    how = inverse, tolerance, iterations, restarts, seed
    reached = _search(system, request, guess, *how)
    led = with_leaders(nominal, reached.q, request.t) if reached.ok else None
    if led is not None:
        reached = _search(system, request, _search(led, request, guess, *how).q, *how)
    if not reached.ok:
        return _open(system, request, reached, tolerance)
    assembly = _velocities(system, _nearest(system, request, inverse, reached, tolerance), given_rates)
    moved = tuple(position_changes(system, guess, assembly.q))
    turned = tuple(velocity_changes(system, guess, speed, assembly.q, assembly.v))
    announce(turned_over(system, assembly.q))
    if t == 0.0:
        announce(warning(system, (*(moved if q is None else ()), *turned)))
    revolutions = prescribed_revolutions(nominal, assembly.q, request.t, np.zeros(0))
    if system is not nominal or len(revolutions):
        assembly = replace(assembly, memory=memory, revolutions=revolutions)
    return replace(assembly, changes=(*moved, *turned))


def _vector(name: str, value: ArrayLike, size: int) -> Array:
    try:
        vector = np.array(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(
            f"{name} must be {size} finite numbers, got {kind(value)}. Pass an array of this length."
        ) from None
    if vector.shape != (size,) or not np.all(np.isfinite(vector)):
        raise ValueError(f"{name} must be {size} finite numbers. Give one for each coordinate.")
    return vector


def _search(
    system: System,
    request: AssemblyRequest,
    begin: Array,
    inverse: Array,
    tolerance: float,
    iterations: int,
    restarts: int,
    seed: int,
) -> SearchEnd:
    """The first search that reaches the constraints, or the one that came nearest."""
    search, random = FeasibleSearch(system.holonomic, inverse, request.t), np.random.default_rng(seed)
    best, steps = search(begin, tolerance, iterations), 0
    between = float(np.ptp(request.q[system.layout.positions], axis=0).max(initial=0.0))
    size = system.layout.scales(between or extent(system, request.q))
    for n in range(restarts):
        if best.ok or not np.any(inverse):
            break
        guess = _shaken(request, size, SHAKES[min(n // 2, len(SHAKES) - 1)], random)
        trial = search(guess, tolerance, iterations)
        steps += trial.steps
        best = trial if trial.residual < best.residual else best
    return replace(best, steps=best.steps + steps)


def _shaken(request: AssemblyRequest, size: Array, part: float, random: np.random.Generator) -> Array:
    shake = part * size * random.normal(size=len(request.q))
    return request.q + np.where(request.held_positions, 0.0, shake)


def _nearest(
    system: System, request: AssemblyRequest, inverse: Array, reached: SearchEnd, tolerance: float
) -> Assembly:
    """Find the nearest consistent coordinates from the first ones, with Φ = 0 to round-off."""
    of_positions = system.holonomic
    least_change = LeastChange(of_positions, request.weight, ~request.held_positions, request.t)
    near = least_change(reached.q, request.q, tolerance)
    last = FeasibleSearch(of_positions, inverse, request.t)(near.q, 0.0, 1)
    steps = reached.steps + near.steps
    how = f"assembled in {steps} steps"
    if not near.stationary:
        how += ", though perhaps not with the least change"
    lam = np.append(near.lam, np.zeros(system.m - system.m_holonomic))
    return Assembly(
        last.q, request.v, True, how, last.residual, steps, lam, nearest=near.stationary, asked=request,
        bodies=system.bodies,
    )  # fmt: skip


def _velocities(system: System, assembly: Assembly, rates: Rates) -> Assembly:
    request = assembly.asked
    assert request is not None
    speed = assemble_velocity(
        system, assembly.q, request.v, request.weight_v, ~request.held_velocities, rates, request.t
    )
    done = replace(assembly, v=speed.v, mu=speed.mu, nu=speed.nu)
    open_rows = abs(speed.gap) > speed.allowed
    if not np.any(open_rows):
        return done
    J = system.Phi_q(assembly.q, request.t)
    rank = rank_of(scaled(J, units(system, assembly.q, J))).rank if request.rates else 0
    if request.rates and rank == system.nq - len(system.states):
        concerned = [joint for joint, rows in system.rows.items() if np.any(open_rows[rows])]
        message = (
            f"{system.name} is assembled, but its joints and drivers leave no degree of freedom there for the rates of "
            f"{', '.join(request.rates)}. Give no rates, or check the points and axes of {', '.join(concerned)}"
        )
        return replace(done, success=False, message=message)
    (gaps, gaps_of_rates), m = np.split(speed.gap, [system.m]), system.m
    opening = open_joints(system, assembly.q, gaps, speed.allowed[:m], request.t, per_second=True)
    rates_missed = zip(request.rates, gaps_of_rates, open_rows[m:], strict=True)
    missed = [f"{name} by {gap:.3g}" for name, gap, is_open in rates_missed if is_open]
    missing = ", ".join(filter(None, [opening, *missed]))
    message = (
        f"{system.name} is assembled, but no velocity satisfies all that is given; missed: {missing}. "
        "Give fewer rates, hold less, or look for a position where the mechanism can move that way"
    )
    return replace(done, success=False, message=message)


def _open(system: System, request: AssemblyRequest, reached: SearchEnd, tolerance: float) -> Assembly:
    system = system.holonomic
    J = system.Phi_q(reached.q, request.t)
    limits = allowed(system.layout, J, reached.q, lever(system, reached.q, J), tolerance)
    missing = open_joints(system, reached.q, reached.Phi, limits, request.t)
    missing = missing or "the unit length of Euler parameters"
    message = (
        f"{system.name} could not be assembled; still open after {reached.steps} steps: {missing}. "
        "Start from poses nearer to the assembled ones, hold less, or look for joints that contradict each other"
    )
    verdict = False, message, reached.residual, reached.steps
    return Assembly(reached.q, request.v, *verdict, asked=request, bodies=system.bodies)
