"""Steps that suit a motion, but not what parameters change in it: derivatives know."""

from __future__ import annotations

from math import factorial
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from tests.analyses.linkages import crooked_door

import sarrus as sr
from sarrus.analyses.equations.block_matrix import PlacedMatrix
from sarrus.analyses.sensitivity.accuracy.derivatives import change_errors
from sarrus.functions import exp

UNTIL = 6.0


def pushed(k: float, length: float = 1.0) -> sr.System:
    """1 kg at rest on a spring, pushed once after 3 s for 20 ms."""
    body = sr.Body("m", 1.0, (1, 1, 1), position=(1, 0, 0))
    guide = sr.Translational("g", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    center = body.point(0, 0, 0)
    spring = sr.TSDA("s", sr.ground.point(1 - length, 0, 0), center, k=k, length=length)
    push = sr.PointForce("push", center, (1, 0, 0), factor=lambda t: 50 * exp(-0.5 * ((t - 3) / 0.005) ** 2))
    return sr.System(sr.Model("pushed", [body], [guide], [spring, push]))


CASES = [
    (4.0, sr.HHT(), np.inf, True),
    (100.0, sr.Radau(), np.inf, True),
    (4.0, sr.HHT(), 0.03, False),
    (100.0, sr.Radau(), 0.03, False),
    (1e-6, sr.HHT(), np.inf, False),
    (1e-6, sr.Radau(), np.inf, False),
]


@pytest.mark.one_in(8)
@pytest.mark.filterwarnings("ignore:.*its derivatives have")
@pytest.mark.parametrize("method", ["adjoint", "direct"])
@pytest.mark.parametrize(("k", "by", "max_step", "wrong"), CASES)
def test_long_steps_at_rest_warn(k: float, by: Any, max_step: float, method: Any, wrong: bool) -> None:
    """The motion is right to a thousandth, while steps are longer than the oscillation that a parameter causes."""
    run = sr.simulate(pushed(k), until=UNTIL, method=by, max_step=max_step, store_steps=True)
    found = sr.sensitivity(run, "m.x", ["m.position.x", "s.length"], method=method)
    cosine = np.cos(np.sqrt(k) * UNTIL)
    error = abs(found.matrix[0] - [cosine, 1 - cosine]).max() / abs(np.array([cosine, 1 - cosine])).max()
    w = np.sqrt(k)
    exact = 1 + 50 * 0.005 * np.sqrt(2 * np.pi) * np.exp(-0.5 * (w * 0.005) ** 2) * np.sin(3 * w) / w
    assert run.output("m.x").values[-1] == pytest.approx(exact, abs=2e-3)
    assert (error > 0.03) == wrong
    assert any("its derivatives have" in one for one in found.warnings) == wrong


@pytest.mark.filterwarnings("ignore:.*its derivatives have")
def test_estimates_tell_how_wrong() -> None:
    run = sr.simulate(pushed(4.0), until=UNTIL, method=sr.HHT(), store_steps=True)
    found = sr.sensitivity(run, "m.x", ["s.length"], error=True)
    error = abs(found.matrix[0, 0] - (1 - np.cos(2 * UNTIL))) / abs(found.matrix[0, 0])
    assert error / 10 < found.relative_errors[0] < 10 * error


@pytest.mark.filterwarnings("ignore:.*its derivatives have")
def test_a_parameter_may_be_tiny() -> None:
    """A relative change of it would move the steps by less than round-off."""
    model, found = pushed(4.0).model, list[float]()
    for k in (0.0, 1e-12, 1e-30):
        tiny = sr.TSDA("tiny", sr.ground.point(-2, 0, 0), model.bodies[0].point(0, 0, 0), k=k, length=1.0)
        system = sr.System(sr.Model("p", model.bodies, model.joints, [*model.forces, tiny]))
        run = sr.simulate(system, until=UNTIL, method=sr.HHT(), store_steps=True)
        found += sr.sensitivity(run, "m.x", ["tiny.k"], error=True).relative_errors
    assert found == pytest.approx(found[:1] * 3, rel=1e-3)


EVERY = ["m.position.x", "m.mass", "s.k", "s.length"]


@pytest.mark.filterwarnings("ignore:.*its derivatives have")
@pytest.mark.parametrize(("k", "error", "looked_at"), [(4.0, False, 1), (4.0, True, 4), (1e-6, False, 2)])
def test_changes_are_looked_at_until_a_warning_is_clear(
    k: float, error: bool, looked_at: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    columns, errors_of = list[int](), change_errors.errors_of_changes
    monkeypatch.setattr(
        change_errors, "errors_of_changes", lambda *given: (columns.append(given[-1]), errors_of(*given))[1]
    )
    run = sr.simulate(pushed(k), until=UNTIL, method=sr.HHT(), store_steps=True)
    found = sr.sensitivity(run, "m.x", EVERY, error=error)
    assert columns == [*range(looked_at)]
    assert bool(found.warnings) == (k == 4.0)


@pytest.mark.filterwarnings("ignore:.*its derivatives have")
def test_moved_steps_take_the_pivots_of_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are chosen for the sweep and the states of the run, not again for each of its moved copies."""
    chosen, choose = list[PlacedMatrix](), PlacedMatrix.choose_pivots
    monkeypatch.setattr(PlacedMatrix, "choose_pivots", lambda own: (chosen.append(own), choose(own))[1])
    run = sr.simulate(pushed(4.0), until=UNTIL, method=sr.HHT(), store_steps=True)
    first, again, moved = (
        (chosen.clear(), sr.sensitivity(run, "m.x", EVERY, error=error), len(chosen))[2]
        for error in (False, False, True)
    )
    assert 0 < first < 7
    assert again == 0
    assert moved <= 2  # for states that `lost_vibrations` looks at


def exact(k: mp.mpf, length: mp.mpf) -> mp.mpf:
    """The place at the end."""
    w = mp.sqrt(k)
    kick = mp.mpf("0.25") * mp.sqrt(2 * mp.pi) * mp.exp(-((w * mp.mpf("0.005")) ** 2) / 2) / w
    return length + (1 - length) * mp.cos(6 * w) + kick * mp.sin(3 * w)


@pytest.mark.filterwarnings("ignore:.*its derivatives have")
def test_errors_of_some_hundredths_warn() -> None:
    """By a long spring: a part of its length moves the mass farther than all pushes."""
    run = sr.simulate(pushed(4.0, 100.0), until=UNTIL, store_steps=True)
    found = sr.sensitivity(run, "m.x", ["s.k", "s.length"])
    wanted = np.array([float(mp.diff(exact, (4, 1), n)) for n in ((1, 0), (0, 1))])
    sizes = np.array([4.0, 100.0])
    error = np.linalg.norm((found.matrix[0] - wanted) * sizes) / np.linalg.norm(wanted * sizes)
    assert 0.01 < error < 0.3
    assert any("its derivatives have" in one for one in found.warnings)


@pytest.mark.filterwarnings("ignore:.*derivatives have")
@pytest.mark.parametrize(("by", "max_step", "wrong"), [(sr.HHT(), np.inf, True), (sr.Radau(), 0.03, False)])
def test_second_derivatives_and_those_of_states_know(by: Any, max_step: float, wrong: bool) -> None:
    run = sr.simulate(pushed(4.0), until=UNTIL, method=by, max_step=max_step, store_steps=True)
    names = ["s.k", "s.length"]
    orders = ((2, 0), (1, 1)), ((1, 1), (0, 2))
    with mp.workdps(30):
        truth = np.array([[float(mp.diff(exact, (4, 1), n)) for n in row] for row in orders])
    hessian = sr.hessian(run, "m.x", names, error=True)
    assert (abs(hessian.matrix - truth).max() > 0.03 * abs(truth).max()) == wrong
    assert hessian.relative_error is not None
    assert (hessian.relative_error > 0.01) == wrong
    product = sr.hessian_product(run, "m.x", {"s.k": 1.0}, names)
    states = sr.state_derivatives(run, names)
    for found, own in (
        (hessian, "its second"),
        (product, "its second"),
        (states, "the states of pushed: its"),
    ):
        assert any(own in one for one in found.warnings) == wrong


def gliding(k: float) -> sr.System:
    """2 kg at 1 m/s with a spring that hardly acts."""
    body = sr.Body("m", 2.0, (1, 1, 1), velocity=(1, 0, 0))
    guide = sr.Translational("g", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("s", sr.ground.point(-5, 0, 0), body.point(0, 0, 0), k=k, length=5.0)
    return sr.System(sr.Model("gliding", [body], [guide], [spring]))


@pytest.mark.filterwarnings("ignore:.*derivatives have")
@pytest.mark.parametrize(("k", "wrong"), [(0.0, 0.12), (1e-4, 0.04), (1e-2, 0.002)])
def test_uniform_motion_has_long_steps(k: float, wrong: float) -> None:
    """x is the sum of (-k/m)ⁿ t²ⁿ⁺¹/(2n + 1)!: its change by k is a cubic, for which these steps are too long."""
    exact = sum(-n / 2 * (-k / 2) ** (n - 1) * 2.0 ** (2 * n + 1) / factorial(2 * n + 1) for n in range(1, 5))
    run = sr.simulate(gliding(k), until=2.0, method=sr.HHT(), store_steps=True)
    found = sr.sensitivity(run, "m.x", ["s.k"], error=True)
    error = abs(found.matrix[0, 0] - exact) / abs(found.matrix[0, 0])
    assert error == pytest.approx(wrong, rel=0.2)
    assert found.relative_errors[0] == pytest.approx(error, rel=0.1)
    every = [
        found,
        sr.sensitivity(run, "m.x", ["s.k"], method="direct"),
        sr.state_derivatives(run, ["s.k"]),
        sr.sensitivity_by_checkpoints(gliding(k), "m.x", ["s.k"], until=2.0, method=sr.HHT()),
    ]
    assert [any("as some steps suit" in one for one in own.warnings) for own in every] == [error > 0.01] * 4


def test_no_warning_of_the_few_steps_of_a_tiny_oscillation() -> None:
    """Of 1e-6 m: changes of stiffness and states that are small for the mechanism are large for the motion."""
    body = sr.Body("m", 1.0, (1, 1, 1), position=(1e-6, 0, 0))
    guide = sr.Translational("g", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("s", sr.ground.point(-1, 0, 0), body.point(0, 0, 0), k=20.0, length=1.0)
    tiny = sr.System(sr.Model("tiny", [body], [guide], [spring]))
    run = sr.simulate(tiny, until=0.05, method=sr.HHT(), store_steps=True)
    found = sr.sensitivity(run, "m.x", ["s.k", "m.mass"], error=True)
    w, t = np.sqrt(20.0), 0.05
    assert found.matrix[0] == pytest.approx(np.array([-0.5, 10.0]) * 1e-6 * t * np.sin(w * t) / w, rel=3e-3)
    assert np.diff(run.steps.t).max() > 0.05 / 15
    assert not found.warnings


@pytest.mark.parametrize("speed", [0.0, 1.0])
def test_round_off_of_a_calm_motion_is_no_error(speed: float) -> None:
    """At rest, or of a constant velocity: errors of the states were compared with round-off, and had no digit."""
    body = sr.Body("m", 2.0, (1, 1, 1), position=(0.1, 0, 0), velocity=(speed, 0, 0))
    guide = sr.Translational("g", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("s", sr.ground.point(-5, 0, 0), body.point(0, 0, 0), k=0.0, length=5.0)
    calm = sr.System(sr.Model("calm", [body], [guide], [spring]))
    run = sr.simulate(calm, until=2.0, store_steps=True)
    found = sr.sensitivity(run, "m.x", ["s.k", "s.c", "m.velocity.x"], error=True)
    assert found.matrix[0] == pytest.approx([-0.1 - speed * 2 / 3, -speed, 2.0], rel=1e-12)
    assert found.relative_errors[0] < 1e-9
    assert not found.warnings


HINGES = {"z": 1.8, "mass": 20.0}


def widened(d: Any) -> dict[str, float]:
    """Of a door: the height of a hinge on the wall and on the panel, the latter not exactly."""
    return {
        "upper.frame_i.point.z": d["z"],
        "upper.frame_j.point.z": (1 + 1e-8) * d["z"] - 1.0,
        "panel.mass": d["mass"],
    }


def test_estimates_of_redundant_constraints_do_not_raise() -> None:
    """A change that contradicts the constraints by 1e-8 of its size has derivatives, and so has its estimate."""
    panel = sr.Body("panel", mass=20.0, inertia=(8.0, 6.0, 2.0), position=(0.4, 0, 1.0))
    joints = [
        sr.Revolute(
            name, sr.ground, panel,
            frame_i=sr.ground.frame((0, 0, z), z=(0, 0, 1)), frame_j=panel.frame((-0.4, 0, z - 1.0), z=(0, 0, 1)),
        )
        for name, z in (("lower", 0.2), ("upper", 1.8))
    ]  # fmt: skip
    system = sr.System(sr.Model("door", [panel], joints, gravity=(0.3, 1.0, -9.81)))
    given = {"until": 0.1, "method": sr.HHT(step=0.02)}
    found = sr.sensitivity(
        sr.simulate(system, store_steps=True, **given), "panel.x", design=HINGES, formula=widened
    )
    again = sr.sensitivity_by_checkpoints(system, "panel.x", design=HINGES, formula=widened, **given)
    for one in (found, again):
        assert one.matrix[0] == pytest.approx([0.0, -4.5457864e-7], rel=1e-6, abs=1e-12)


@pytest.mark.filterwarnings("ignore:.*nothing can move")
def test_a_stuck_mechanism_has_derivatives_and_no_oscillations() -> None:
    run = sr.simulate(crooked_door(), until=0.1, store_steps=True)
    assert abs(sr.sensitivity(run, "energy.kinetic", ["panel.mass"], error=True).matrix).max() < 1e-12
    assert run.error("energy.kinetic").vibrations == 0.0
