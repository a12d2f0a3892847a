"""Static equilibrium: Φ_qᵀ lam = Q at rest, Φ = 0."""

from __future__ import annotations

import numpy as np

from ...algebra import Array
from ...linalg.threads import one_thread_if_small
from ...model.announcement import announce, reports_warnings
from ...results import Equilibrium
from ...results.equilibrium import Stability
from ...system import System
from ..arguments import refuse_other_system
from ..driven.steps import coordinate_scale
from ..equations.length import lever
from ..equations.nullspace import refuse_missing_inertia
from ..equations.projection import largest, onto
from ..equations.states_at_rest import following, places, settled_states, sizes, undetermined, with_states
from ..equations.table_ranges import announce_left_ranges
from ..position.initial_state import PartialState, Start, state_of
from ..redundancy.degrees_of_freedom import mobility
from .balance import FINISHED, Balance

BY_PATH = "which positions it reaches depends on its path. Simulate it with dampers until it is at rest."
ROUND_OFF = 1e-7  # ... that is the last one, if the next is no shorter
REPETITIONS = 5  # of a failed search that share its number of steps: those that succeed take few
SYMMETRIC = 1e-8  # asymmetry of the Hessian, relative to its terms before they cancel, that is round-off
LONGEST = 0.2  # change of a coordinate in one step, in parts of the model's size
FIRST = 0.15  # of the longest step
# work done over work expected: below, the step is taken back; above, the next may be longer
POOR, GOOD = 0.2, 0.8
PUSH = 1e-6  # displacement along an unstable direction, in parts of the model's size
TINY = 1e-300
# Rounds of the search for the damping of a step, and what it looks at in each: in the end round-off of the range
ROUNDS, SHARES = 8, np.linspace(0.0, 1.0, 65)
SHARE = 1e-10  # of the force: what along a neutral direction is round-off


@reports_warnings
@one_thread_if_small
def equilibrium(
    system: System,
    q: Start | None = None,
    *,
    t: float | None = None,
    stable: bool = True,
    iterations: int = 500,
    longest: float = LONGEST,
) -> Equilibrium:
    """Find a static equilibrium.

    Newton's method on the equations Φ_qᵀ lam - Q = 0, Φ = 0 with the exact derivatives (Φ_qᵀ lam)_q and Q_q, solved
    along the free directions. Far from a solution, or if the potential energy would increase, steps are rotated towards
    lower energy. The work of the forces decides whether a step is accepted, so that the search ends in a stable
    equilibrium. First-order states follow the position, so that their rates are zero. Where they cannot, as those of
    integrators, they are sought with the position, and the nearest equilibrium is found, be it stable or not.

    Parameters
    ----------
    system : System
    q : (nq,) the initial position, or an `Assembly`, a `State` or an `Equilibrium`; by default the model's
    t : time at which drivers and forces are evaluated [s]; by default that of the start, or 0
    stable : find a stable equilibrium; if false, the nearest one, stable or not
    iterations : largest number of steps; a search that fails may be repeated with other states that follow the
        position, with as many steps for all repetitions together
    longest : largest change of a coordinate in one step, in parts of the model's size; with a smaller one the search
        stays closer to the way downhill, and does not leap over a nearer equilibrium

    Returns
    -------
    Equilibrium
        With ``success`` false and a message if none is found: a joint remains open, or the motion has no end.
    """
    refuse_other_system(system, "equilibrium", nonholonomic=BY_PATH)
    begin = state_of(system, system.q0 if q is None else q, None, t)
    start, t = with_states(system, begin.q, system.v0 if begin.v is None else begin.v), begin.t
    search = _Search(system, begin, longest)
    assembled, reached = onto(system, start, t, b=search.b)
    if not reached:
        gap = largest(system.Phi(assembled, t, b=search.b))
        message = f"{system.name} could not be assembled, |Φ| = {gap:.3g} remains. Assemble it first"
        return search.result(search.at(assembled), False, message, 0)
    return search.run(assembled, stable, iterations)


class _Search:
    """State of one search."""

    def __init__(self, system: System, start: PartialState, longest: float) -> None:
        self.system, self.t, self.b = system, start.t, start.parameters(system)
        self.scale = coordinate_scale(system, start.q)
        self.length = lever(system, start.q, system.Phi_q(start.q, self.t, b=self.b))
        joints = system.joint_coordinates
        self.angles = joints.with_revolutions(joints.Phi(start.q), start.revolutions)
        self.longest, self.radius, self.settled = longest, FIRST * longest, places(system)[:0]
        self.way: list[Array] = []

    @property
    def follow(self) -> bool:
        """Whether all states follow the position."""
        return len(self.settled) == len(self.system.states)

    def at(self, q: Array) -> Balance:
        self.system.remember(q, self.b, self.t)
        if len(self.settled):
            q_settled = settled_states(self.system, q, self.t, self.b, self.settled)
            if q_settled is not None:
                return Balance(self.system, q_settled, self.t, self.b, self.settled, self.length)
        return Balance(self.system, q, self.t, self.b, length=self.length)

    def run(self, q: Array, stable: bool, iterations: int) -> Equilibrium:
        """Return the equilibrium for the states that follow the position at first, or for those that do on the way.

        The integral of a controller follows only where limits act on its output.
        """
        refuse_missing_inertia(self.system, q, self.at(q).Z, self.system.M(q, b=self.b))
        settled = following(self.system, q, self.t, self.b)
        if len(settled) and settled_states(self.system, q, self.t, self.b, settled) is None:
            settled = settled[:0]
        result = first = self._searched(q, settled, stable, iterations)
        tried, left = [list(settled)], iterations
        while not result.success and left > 0 and (other := self._other(tried)) is not None:
            way, settled = other
            tried.append(list(settled))
            for begin in (way, q):
                most = min(left, -(-iterations // REPETITIONS))
                result = self._searched(begin, settled, stable, most)
                left -= result.iterations
                if result.success or left <= 0:
                    break
        return result if result.success else first

    def _other(self, tried: list[list[int]]) -> tuple[Array, Array] | None:
        """The last position on the way where the states that follow are not those that were tried, and these states."""
        for q in reversed(self.way if self.system.states else []):
            settled = following(self.system, q, self.t, self.b)
            if list(settled) not in tried:
                return q, settled
        return None

    def _searched(self, q: Array, settled: Array, stable: bool, iterations: int) -> Equilibrium:
        self.settled, self.radius, self.way = settled, FIRST * self.longest, []
        stable = stable and self.follow
        now, last = self.at(q), np.inf
        for count in range(iterations):
            self.way.append(now.q)
            self._count(now.q)
            step = slide_step(now, self.scale, self.radius) if stable else newton_step(now)
            self._rescale(now.q, step)
            size = largest(step / self.scale)
            if size <= FINISHED or (size <= ROUND_OFF and size >= last):
                return self._verdict(now, count, size)
            then = self._downhill(now, step) if stable else self._shorter(now, step)
            if then is None:
                return self._verdict(now, count, size)
            now, last = then, size
        return self._verdict(now, iterations, np.inf)

    def _count(self, q: Array) -> None:
        """Count the revolutions of the joints' angles on the way of the search."""
        joints = self.system.joint_coordinates
        self.angles = joints.near(joints.Phi(q), self.angles)

    def _rescale(self, q: Array, step: Array) -> None:
        """States have their own values as scales."""
        states = places(self.system)
        self.scale[states] = np.maximum(sizes(self.system, q), abs(q[states] + step[states]))

    def _downhill(self, now: Balance, step: Array) -> Balance | None:
        """The next position; the forces must do work on the way there."""
        for _ in range(40):
            size = largest(step / self.scale)
            there = self._moved(now, step)
            quality = _work(now, there) / max(_expected(now, step), 1e-300) if there is not None else 0.0
            if there is not None and (size <= ROUND_OFF or quality > POOR):
                grown = 2 * size if quality > GOOD else size
                self.radius = min(max(grown, FINISHED), self.longest)
                return there
            self.radius = 0.3 * size
            step = slide_step(now, self.scale, self.radius)
        return None

    def _shorter(self, now: Balance, step: Array) -> Balance | None:
        """The next position; the unbalanced force must become smaller, or the next step, which has no mixed units."""
        whole = largest(step / self.scale)
        step, size = step * min(1.0, self.longest / max(whole, 1e-300)), min(whole, self.longest)
        for halvings in range(30):
            there = self._moved(now, step * 0.5**halvings)
            if there is None:
                continue
            if there.acceleration < now.acceleration or size <= ROUND_OFF:
                return there
            if largest(newton_step(there) / self.scale) < whole:
                return there
        return None

    def _moved(self, now: Balance, step: Array) -> Balance | None:
        q, reached = onto(self.system, now.q + step, self.t, b=self.b, length=self.length)
        if not reached or largest((q - now.q) / self.scale) >= 2 * self.longest:
            return None
        there = self.at(q)
        return there if np.all(np.isfinite(there.Q)) else None

    def _verdict(self, now: Balance, count: int, size: float) -> Equilibrium:
        if size <= ROUND_OFF and now.balanced(self.scale):
            message = f"{self.system.name} balances after {count} steps; {_words(now)}{self._crossing(now)}"
            self._warn_of_guesses(now)
            t, q, memory = np.array([self.t]), now.q[None], self.b[None, self.system.memory_places]
            announce_left_ranges(self.system, self.b, t, q, 0.0 * q, memory)
            return self.result(now, True, message, count)
        message = (
            f"{self.system.name}: no equilibrium found in {count} steps, a force of {now.residual:.3g} remains; "
            "it may be free to fall or to turn for ever, or start from another position"
        )
        return self.result(now, False, message, count)

    def _warn_of_guesses(self, now: Balance) -> None:
        """Warn of states with values that are arbitrary, as that of an integral of what is zero at rest."""
        if not self.follow and (names := undetermined(self.system, now.Z, now.H)):
            about = f"{self.system.name}: no equation determines {', '.join(names)} in this equilibrium"
            remedy = "Simulate until the motion is at rest, or give a rate that depends on the state."
            announce([f"{about}, so the value is arbitrary. {remedy}"])

    def _crossing(self, now: Balance) -> str:
        """Return the addition to the message where the constraints lose rank, and not all motions are finite."""
        if now.space.regular or mobility(self.system, now.q, t=self.t).kind not in ("branching", "shaky"):
            return ""
        return "; the constraints lose rank here, so that not all of these motions are finite"

    def result(self, now: Balance, success: bool, message: str, count: int) -> Equilibrium:
        self._count(now.q)
        spectrum, memory = now.spectrum, self.b[self.system.memory_places]
        stability = stability_of(now) if success else "unknown"
        motions = now.Z @ spectrum.vectors
        q = with_states(self.system, now.q, 0.0 * now.q)
        return Equilibrium(
            *(self.system.name, q, now.lam, success, message, stability),
            *(spectrum.squares, motions, now.residual, count),
            t=self.t,
            system=self.system.with_memory(memory),
            v=now.rest,
            memory=memory,
            revolutions=self.system.joint_coordinates.revolutions(self.angles, now.q),
        )


def stability_of(now: Balance) -> Stability:
    """Return the stability from the sign of the smallest eigenvalue of the constrained Hessian."""
    squares, neutral = now.spectrum.squares, now.spectrum.neutral
    if now.asymmetry > SYMMETRIC:
        return "unknown"
    if np.any(squares[~neutral] < 0):
        return "unstable"
    return "neutral" if np.any(neutral) else "stable"


def _words(now: Balance) -> str:
    squares, neutral = now.spectrum.squares, now.spectrum.neutral
    if now.asymmetry > SYMMETRIC:
        return "its forces have no potential, so that only `modes` can determine whether it is stable"
    if not len(squares):
        return "it cannot move at all"
    if stability_of(now) == "unstable":
        count = int(np.count_nonzero(squares[~neutral] < 0))
        return f"it is unstable along {count} motion{'s' if count > 1 else ''}"
    stiff = squares[~neutral]
    smallest = f"{np.sqrt(stiff.min()) / (2 * np.pi):.6g} Hz" if len(stiff) else ""
    if np.any(neutral):
        count = int(np.count_nonzero(neutral))
        message = f"{count} motion{'s have' if count > 1 else ' has'} no stiffness"
        return f"{message}; the smallest frequency of the others is {smallest}" if smallest else message
    return f"it is stable, the smallest frequency is {smallest}"


def _work(now: Balance, then: Balance) -> float:
    """Return the work of the forces on bodies from one position to another, by the trapezoidal rule."""
    bodies = slice(now.system.moving)  # rates of states are round-off, but their changes may be large
    return float(0.5 * (now.Q + then.Q)[bodies] @ (then.q - now.q)[bodies])


def _expected(now: Balance, step: Array) -> float:
    y = now.share @ step
    return float(now.g @ y - 0.5 * y @ now.H @ y)


def newton_step(now: Balance) -> Array:
    """Z y with H y = g; nothing along neutral directions (nq,)."""
    if now.system.states:
        sizes = np.maximum(abs(now.H).max(axis=1), TINY)  # forces and rates of states have different units
        return np.asarray(now.Z @ np.linalg.lstsq(now.H / sizes[:, None], now.g / sizes, rcond=None)[0])
    spectrum = now.spectrum
    keep = spectrum.vectors[:, ~spectrum.neutral]
    return np.asarray(now.Z @ (keep @ np.linalg.lstsq(keep.T @ now.H @ keep, keep.T @ now.g, rcond=None)[0]))


def slide_step(now: Balance, scale: Array, radius: float) -> Array:
    """Z y with (H + σ W) y = g, for the smallest σ ≥ 0 that makes H + σ W positive and no change too large (nq,).

    Where σ is 0 this is Newton's step. With a large σ it is the motion through a very viscous fluid.
    """
    spectrum = now.spectrum
    lowest = spectrum.squares[~spectrum.neutral].min(initial=np.inf)
    if lowest > 0 and not _drifts(now):
        step = newton_step(now)
        if _size(step, scale) <= radius:
            return step
    return _bent(now, scale, radius)


def _drifts(now: Balance) -> bool:
    """Whether a force acts along a direction without stiffness."""
    share = now.spectrum.vectors.T @ now.g
    loose = abs(share[now.spectrum.neutral]).max(initial=0.0)
    return bool(loose > SHARE * np.linalg.norm(abs(now.Z @ now.spectrum.vectors).T @ now.force_terms))


def _bent(now: Balance, scale: Array, radius: float) -> Array:
    """Search for σ on a logarithmic scale, many values at a time."""
    squares, share, modes = now.spectrum.squares, _shaken(now, scale)[:, None], now.Z @ now.spectrum.vectors
    scaled = modes / scale[:, None]
    top = float(abs(squares).max(initial=0.0)) or 1.0
    stiffness = (squares + max(0.0, -squares.min(initial=0.0)))[:, None]

    def sizes(sigma: Array | float) -> Array:
        return np.asarray(abs(scaled @ (share / (stiffness + sigma))).max(axis=0, initial=0.0))

    low, high = 1e-14 * top, top
    while sizes(high)[0] > radius:
        high *= 10
    for _ in range(ROUNDS):
        sigma = low * (high / low) ** SHARES
        too_long = sizes(sigma) > radius
        first = len(sigma) - 1 - int(np.argmax(too_long[::-1])) if too_long.any() else 0
        low, high = sigma[first], sigma[min(first + 1, len(sigma) - 1)]
    return np.asarray(modes @ (share / (stiffness + high)))[:, 0]


def _shaken(now: Balance, scale: Array) -> Array:
    """The forces on the vibration modes; a little is added on unstable ones, where they might be exactly zero.

    It is the force of a displacement by `PUSH` along the mode.
    """
    share = now.spectrum.vectors.T @ now.g
    unstable = (now.spectrum.squares < 0) & ~now.spectrum.neutral
    sizes = abs((now.Z @ now.spectrum.vectors) / scale[:, None]).max(axis=0)
    least = PUSH * abs(now.spectrum.squares) / sizes
    push = np.where(share < 0, -1.0, 1.0) * least
    return np.asarray(np.where(unstable & (abs(share) < least), push, share))


def _size(step: Array, scale: Array) -> float:
    return float(abs(step / scale).max(initial=0.0))
