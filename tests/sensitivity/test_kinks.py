"""Responses with kinks (abs, max, min, clip) against quadrature of closed forms, which ends at the kinks."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from tests.sensitivity.checkpoints import by_checkpoints
from tests.sensitivity.test_events import BOUNCE, ball

import sarrus as sr
from sarrus import functions
from sarrus.analyses.sensitivity import long_run

X0, K, END = 0.3, 10.0, 3.0
NAMES = ["m.position.x", "s.k"]
RADAU = {"method": sr.Radau(rtol=1e-10, atol=1e-12)}


def oscillator() -> sr.System:
    """A mass of 1 kg on a spring: x = x0 cos(sqrt(k) t)."""
    m = sr.Body("m", mass=1, inertia=(1, 1, 1), position=(X0, 0, 0))
    slide = sr.Translational("g", sr.ground, m, point=(X0, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("s", sr.ground.point(-5, 0, 0), m.point(0, 0, 0), k=K, length=5.0)
    return sr.System(sr.Model("osc", [m], [slide], [spring]))


@pytest.fixture(scope="module")
def run() -> sr.Trajectory:
    return sr.simulate(oscillator(), until=END, store="steps", **RADAU)


def x(t: float) -> float:
    return X0 * np.cos(np.sqrt(K) * t)


def x_p(t: float) -> np.ndarray:
    """Its derivatives by x0 and k."""
    w = np.sqrt(K)
    return np.array([np.cos(w * t), -X0 * np.sin(w * t) * t / (2 * w)])


def crossings(level: float) -> list[float]:
    first = np.arccos(level / X0)
    phases = [sign * first + 2 * np.pi * n for n in range(3) for sign in (-1, 1)]
    return [t for t in np.array(phases) / np.sqrt(K) if 0 < t < END]


def integrated(function: Callable[[float], float], *levels: float) -> float:
    """An integral over the run that is cut where x passes the levels."""
    cuts = sorted([0.0, END, *(t for level in levels for t in crossings(level))])
    return sum(quad(function, a, b, epsabs=1e-13, epsrel=1e-13)[0] for a, b in pairwise(cuts))


LEVEL = 0.1
KINKED = {
    # of x: the response's function, the value and slope for numbers, levels with kinks
    "abs": (lambda x: np.abs(x), abs, np.sign, [0.0]),
    "fabs": (lambda x: np.fabs(x), abs, np.sign, [0.0]),
    "builtin abs": (lambda x: abs(x - LEVEL), lambda x: abs(x - LEVEL), lambda x: np.sign(x - LEVEL), [LEVEL]),
    "no bound below": (
        lambda x: np.clip(x, -np.inf, LEVEL),
        lambda x: min(x, LEVEL),
        lambda x: float(x < LEVEL),
        [LEVEL],
    ),
    "sizes apart": (lambda x: np.maximum(1e17 * x - 1e17, 1.0), lambda x: 1.0, lambda x: 0.0, []),
    "maximum": (lambda x: np.maximum(x, LEVEL), lambda x: max(x, LEVEL), lambda x: float(x > LEVEL), [LEVEL]),
    "minimum": (lambda x: np.minimum(LEVEL, x), lambda x: min(x, LEVEL), lambda x: float(x < LEVEL), [LEVEL]),
    "fmax": (lambda x: np.fmax(x, 0) ** 2, lambda x: max(x, 0) ** 2, lambda x: 2 * max(x, 0), [0.0]),
    "fmin": (lambda x: np.fmin(x, 0), lambda x: min(x, 0), lambda x: float(x < 0), [0.0]),
    "clip": (
        lambda x: np.clip(x, -0.2, LEVEL),
        lambda x: min(max(x, -0.2), LEVEL),
        lambda x: float(-0.2 < x < LEVEL),
        [-0.2, LEVEL],
    ),
    "ramp": (lambda x: functions.ramp(x), lambda x: max(x, 0), lambda x: float(x > 0), [0.0]),
    "functions": (
        lambda x: functions.min(functions.max(x, -0.2), functions.absolute(LEVEL)),
        lambda x: min(max(x, -0.2), LEVEL),
        lambda x: float(-0.2 < x < LEVEL),
        [-0.2, LEVEL],
    ),
    "nested": (
        lambda x: np.abs(np.abs(x) - LEVEL),
        lambda x: abs(abs(x) - LEVEL),
        lambda x: np.sign(abs(x) - LEVEL) * np.sign(x),
        [-LEVEL, 0.0, LEVEL],
    ),
    "nearly touching": (
        lambda x: np.abs(x - 0.2999),
        lambda x: abs(x - 0.2999),
        lambda x: np.sign(x - 0.2999),
        [0.2999],
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", KINKED)
def test_integrals_and_their_derivatives(kind: str, run: sr.Trajectory) -> None:
    function, value, slope, levels = KINKED[kind]
    found = sr.sensitivity(run, sr.Integral(lambda o: function(o("m.x"))), NAMES)
    wanted = [integrated(lambda t, n=n: slope(x(t)) * x_p(t)[n], *levels) for n in (0, 1)]
    assert found.value == pytest.approx(integrated(lambda t: value(x(t)), *levels), rel=1e-8)
    assert found.matrix[0] == pytest.approx(wanted, rel=1e-7, abs=3e-8)


def test_forwards_backwards_and_steps_of_order_two(run: sr.Trajectory) -> None:
    response = sr.Integral(lambda o: np.abs(o("m.x")))
    adjoint, direct = (sr.sensitivity(run, response, NAMES, method=one) for one in ("adjoint", "direct"))
    assert direct.matrix == pytest.approx(adjoint.matrix, rel=1e-9)
    wanted = np.array([integrated(lambda t, n=n: np.sign(x(t)) * x_p(t)[n], 0.0) for n in (0, 1)])
    errors = []
    for step in (0.01, 0.005):
        settings = {"method": sr.HHT(step=step), "store": "steps"}
        coarse = sr.sensitivity(sr.simulate(oscillator(), until=END, **settings), response, NAMES)
        errors.append(abs(coarse.matrix[0] - wanted).max())
    assert errors[0] < 2e-3
    assert errors[1] < 0.4 * errors[0]  # of the order of the steps, 2


def test_an_extreme_at_a_kink_does_not_move_with_the_time_of_the_kink(run: sr.Trajectory) -> None:
    """Of y = 2 |x| + t, the least in the middle is the time at which x vanishes, π/2 / sqrt(k)."""
    bound = np.pi / (2 * np.sqrt(K))
    response = sr.Minimum(lambda o: 2 * np.abs(o("m.x")) + o.t)
    found = sr.sensitivity(run, response, NAMES)
    assert found.value == pytest.approx(bound, rel=1e-9)
    assert found.matrix[0] == pytest.approx([0.0, -bound / (2 * K)], abs=1e-8)
    found = sr.sensitivity(run, sr.Maximum(lambda o: -2 * np.abs(o("m.x")) - o.t), NAMES)
    assert found.value == pytest.approx(-bound, rel=1e-9)
    assert found.matrix[0] == pytest.approx([0.0, bound / (2 * K)], abs=1e-8)


def bounced(height: float, restitution: float, level: float = 0.4, end: float = 2.0) -> float:
    """∫ |z - level| dt of the ball of `test_events`, by quadrature of its flights."""
    z, v, g, t, total = height, 0.5, 9.81, 0.0, 0.0
    while t < end:
        flight = min((v + np.sqrt(v**2 + 2 * g * z)) / g, end - t)
        roots = np.roots([-g / 2, v, z - level])
        cuts = sorted(
            [0.0, flight, *(float(r.real) for r in roots if abs(r.imag) < 1e-12 and 0 < r.real < flight)]
        )
        for a, b in pairwise(cuts):
            total += quad(lambda s, z=z, v=v: abs(z + v * s - g * s**2 / 2 - level), a, b, epsabs=1e-14)[0]
        z, v, t = 0.0, restitution * np.sqrt(v**2 + 2 * g * z), t + flight
    return total


def test_kinks_between_events() -> None:
    """Impacts move the times of nodes and of kinks."""
    begun = sr.simulate(ball(), until=2.0, events=BOUNCE, store="steps", method=sr.Radau())
    found = sr.sensitivity(
        begun, sr.Integral(lambda o: np.abs(o("ball.z") - 0.4)), ["ball.position.z", "bounce.restitution"]
    )
    assert found.value == pytest.approx(bounced(1.0, 0.8), rel=1e-9)
    e = 1e-6
    wanted = [
        (bounced(1.0 + e, 0.8) - bounced(1.0 - e, 0.8)) / (2 * e),
        (bounced(1.0, 0.8 + e) - bounced(1.0, 0.8 - e)) / (2 * e),
    ]
    assert found.matrix[0] == pytest.approx(wanted, rel=1e-6)


def bent(slope: Callable[[float], float], levels: list[float]) -> np.ndarray:
    """The Hessian of an integral by x0 and k: differences of its gradient by quadrature between the kinks."""

    def gradient(x0: float, k: float) -> np.ndarray:
        w = np.sqrt(k)
        first = [np.arccos(level / x0) for level in levels]
        phases = np.array([s * one + 2 * np.pi * n for one in first for n in range(3) for s in (-1, 1)]) / w
        cuts = sorted([0.0, END, *(t for t in phases if 0 < t < END)])
        by = (lambda t: np.cos(w * t), lambda t: -x0 * np.sin(w * t) * t / (2 * w))
        return np.array([
            sum(quad(lambda t, one=one: slope(x0 * np.cos(w * t)) * one(t), a, b, epsabs=1e-13)[0]
                for a, b in pairwise(cuts))
            for one in by
        ])  # fmt: skip

    def along(size: np.ndarray) -> np.ndarray:
        ends = [gradient(X0 + s * size[0], K + s * size[1]) for s in (1, -1, 2, -2)]
        return (8 * (ends[0] - ends[1]) - (ends[2] - ends[3])) / (12 * size.sum())

    return np.array([along(np.array([1e-4, 0])), along(np.array([0, 3e-3]))])


@pytest.mark.parametrize("kind", ["abs", "builtin abs", "maximum", "fmax", "clip", "nested"])
def test_hessians_of_integrals(kind: str, run: sr.Trajectory) -> None:
    """A kink moves, and with it what belongs to either side."""
    function, _, slope, levels = KINKED[kind]
    found = sr.hessian(run, sr.Integral(lambda o: function(o("m.x"))), NAMES)
    wanted = bent(slope, levels)
    assert found.asymmetry < 1e-9
    assert found.matrix == pytest.approx(wanted, rel=0, abs=2e-6 * abs(wanted).max())


def test_hessians_of_integrals_of_accelerations_and_with_steps_of_order_two(run: sr.Trajectory) -> None:
    """|a| = k |x|; the error of a method of order two falls with the square of its steps."""
    wanted, slope = (
        bent(np.sign, [0.0]),
        [integrated(lambda t, n=n: np.sign(x(t)) * x_p(t)[n], 0.0) for n in (0, 1)],
    )
    found = sr.hessian(run, sr.Integral(lambda o: np.abs(o("m.acceleration.x"))), NAMES).matrix
    by_k = np.array([[0.0, slope[0]], [slope[0], 2 * slope[1]]])
    assert found == pytest.approx(K * wanted + by_k, rel=0, abs=2e-6 * abs(K * wanted).max())
    errors = []
    for step in (0.01, 0.005):
        coarse = sr.simulate(oscillator(), until=END, method=sr.HHT(step=step), store="steps")
        errors.append(
            abs(sr.hessian(coarse, sr.Integral(lambda o: np.abs(o("m.x"))), NAMES).matrix - wanted).max()
        )
    assert errors[0] < 1e-2 * abs(wanted).max()
    assert errors[1] < 0.4 * errors[0]


def test_hessians_of_kinks_between_events() -> None:
    begun = sr.simulate(ball(), until=2.0, events=BOUNCE, store="steps", method=sr.Radau())
    names = ["ball.position.z", "bounce.restitution"]
    found = sr.hessian(begun, sr.Integral(lambda o: np.abs(o("ball.z") - 0.4)), names)

    def differenced(e: float) -> np.ndarray:
        mixed = sum(s * r * bounced(1 + s * e, 0.8 + r * e) for s in (1, -1) for r in (1, -1)) / (4 * e * e)
        own = [
            sum(w * bounced(1 + h * s * e, 0.8 + r * s * e) for s, w in ((-1, 1), (0, -2), (1, 1))) / e**2
            for h, r in ((1, 0), (0, 1))
        ]
        return np.array([[own[0], mixed], [mixed, own[1]]])

    wanted = (4 * differenced(5e-4) - differenced(1e-3)) / 3
    assert found.matrix == pytest.approx(wanted, rel=0, abs=1e-4 * abs(wanted).max())


def drifting(o: sr.Outputs) -> object:
    """Least where x first passes the level, at arccos(level / x0) / sqrt(k)."""
    return np.abs(o("m.x") - LEVEL) + 0.3 * o.t


def hessian_of_the_crossing() -> np.ndarray:
    """That of the time of the crossing by x0 and k, in closed form."""
    w, root = np.sqrt(K), np.sqrt(X0**2 - LEVEL**2)
    angle, slope = np.arccos(LEVEL / X0), LEVEL / (X0 * root)
    bend = -LEVEL * (2 * X0**2 - LEVEL**2) / (X0**2 * root**3)
    return np.array([[bend / w, -slope / (2 * w**3)], [-slope / (2 * w**3), 0.75 * angle / w**5]])


def test_hessians_of_extremes_at_kinks(run: sr.Trajectory) -> None:
    """The intersection of both sides moves along a curve."""
    wanted = 0.3 * hessian_of_the_crossing()
    for response in (
        sr.Minimum(drifting),
        sr.Maximum(lambda o: -1 * drifting(o)),
    ):
        sign = 1.0 if isinstance(response, sr.Minimum) else -1.0
        found = sr.hessian(run, response, NAMES)
        assert found.asymmetry < 1e-9
        assert sign * found.matrix == pytest.approx(wanted, rel=0, abs=1e-5 * abs(wanted).max())


def test_hessians_of_extremes_at_kinks_with_steps_of_order_two() -> None:
    """Their error falls with the steps."""
    wanted, errors = 0.3 * hessian_of_the_crossing(), []
    for step in (0.004, 0.001):
        coarse = sr.simulate(oscillator(), until=0.5, method=sr.HHT(step=step), store="steps")
        errors.append(abs(sr.hessian(coarse, sr.Minimum(drifting), NAMES).matrix - wanted).max())
    assert errors[0] < 1e-2 * abs(wanted).max()
    assert errors[1] < 0.4 * errors[0]


def test_kinks_of_runs_without_stored_states(run: sr.Trajectory, monkeypatch: pytest.MonkeyPatch) -> None:
    """Their steps are split, too, interval by interval."""
    monkeypatch.setattr(long_run, "FIRST", 5)
    responses = [sr.Integral(lambda o: np.abs(o("m.x"))), sr.Minimum(drifting)]
    wanted = sr.sensitivity(run, responses, NAMES)
    found = by_checkpoints(oscillator(), responses, NAMES, until=run.t[-1], **RADAU)
    assert found.values == pytest.approx(wanted.values, rel=1e-12)
    np.testing.assert_allclose(found.matrix, wanted.matrix, rtol=1e-10, atol=1e-12)


def test_an_absolute_value_without_kinks_is_smooth(run: sr.Trajectory) -> None:
    smooth = sr.Integral(lambda o: np.abs(o("m.x") + 1))  # never zero
    other = sr.Integral(lambda o: o("m.x") + 1)
    assert sr.hessian(run, smooth, NAMES).matrix == pytest.approx(
        sr.hessian(run, other, NAMES).matrix, rel=1e-9
    )


@pytest.mark.parametrize(
    "function", [np.sign, np.floor, lambda x: np.where(x > 0, 1.0, 0.0), lambda x: max(x, 0)]
)
def test_jumps_and_branches_are_refused(function: Callable, run: sr.Trajectory) -> None:
    with pytest.raises(TypeError, match=r"np\.maximum"):
        sr.sensitivity(run, sr.Integral(lambda o: function(o("m.x"))), NAMES)
