"""Forward and backward derivatives agree, and agree with differences of whole simulations with the same steps."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.sensitivity.frozen import again, differenced, solved, values
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.sensitivity.parameters.parameters import Parameters
from sarrus.analyses.sensitivity.steps import sweep
from sarrus.analyses.sensitivity.steps.matrix import OperationMatrix
from sarrus.analyses.sensitivity.steps.record import Record

pytestmark = [
    pytest.mark.filterwarnings("ignore:.*assembly changed"),  # states here are drawn roughly
]

METHODS = {"HHT": sr.HHT(), "generalized": sr.GeneralizedAlpha(0.7), "undamped": sr.HHT(0.0)}
RESPONSES = [
    sr.Final("slider.x"),
    sr.Final("slider.velocity.x"),
    sr.Integral(lambda o: o("slider.velocity.x") ** 2, name="v2"),
    sr.At("pin.angle", time=0.37),
    sr.At("pin.angle.rate", time=0.71),
    sr.Integral("energy.kinetic"),
    sr.Maximum("spring.length"),
    sr.Final("spring.tension"),
    sr.Final(lambda o: o.position("rod", (0.1, 0.2, 0.3))[1] * o.velocity("rod", (0.1, 0, 0))[2], name="rod"),
    sr.Misfit("slider.x", at=(0.1, 0.25, 0.5), data=(4.1, 4.0, 3.9), sigma=0.1),
    sr.At("rod.acceleration.y", time=0.5),
    sr.Final("pin.force.z"),
    sr.Final("guide.torque.x"),
    sr.Final("pin.multiplier.2"),
    sr.Integral(lambda o: np.sqrt(1 + o("crank.angular_velocity.x") ** 2), name="turning"),
    sr.Maximum("slider.velocity.x"),
]
ROUGH = {
    "rod.acceleration.y",
    "pin.force.z",
    "guide.torque.x",
    "pin.multiplier.2",
}  # differences lose digits by h⁻²


@cache
def swung(method: str) -> sr.Trajectory:
    run = sr.simulate(
        slider_crank(), until=0.8, method=replace(METHODS[method], rtol=1e-4, atol=1e-6), store="steps"
    )
    return solved(run, METHODS[method])


@cache
def both(method: str) -> tuple[sr.Gradient, sr.Gradient]:
    run = swung(method)
    return tuple(sr.sensitivity(run, RESPONSES, method=way) for way in ("direct", "adjoint"))


@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", METHODS)
def test_forward_and_backward_agree_for_every_number_of_the_model(method: str) -> None:
    direct, adjoint = both(method)
    assert len(direct.names) == 88
    for row, title in enumerate(direct.responses):
        scale = abs(direct.matrix[row]).max()
        assert scale > 0
        rough = any(word in title for word in ROUGH)  # 8e-11 here, 6e-11 with other lanes
        limit = (3 if rough else 1) * (1e-9 if method == "undamped" else 1e-10)  # undamped, so is round-off
        assert abs(direct.matrix[row] - adjoint.matrix[row]).max() < limit * scale, title


NAMES = [
    "crank.mass",
    "rod.inertia.yy",
    "slider.mass",
    "spring.k",
    "spring.c",
    "spring.length",
    "spring.point_i.y",
    "gravity.z",
    "pin.point.y",
    "ball.point.z",
    "rod.position.x",
    "crank.orientation.angle",
    "crank.angular_velocity.x",
    "slider.velocity.x",
    "guide.point.z",
]


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", NAMES)
def test_gradients_are_those_of_differenced_simulations(name: str) -> None:
    direct, _ = both("HHT")
    found, wanted = direct[name], differenced(swung("HHT"), RESPONSES, name, 2e-3, METHODS["HHT"])
    for row, title in enumerate(direct.responses):
        rough = any(word in title for word in ROUGH)
        scale = max(abs(direct.matrix[row]).max(), 1e-3)
        assert abs(found[row] - wanted[row]) < (1e-4 if rough else 1e-7) * scale, title


def test_what_a_gradient_leaves_falls_with_the_square() -> None:
    """Taylor's remainder with all numbers changed at once."""
    run = swung("HHT")
    names = [
        name for name in Parameters(run.system).names if "axis" not in name and "orientation.e" not in name
    ]
    at = Parameters(run.system, names).values
    change = np.random.default_rng(3).normal(size=len(names)) * 0.1
    gradient = sr.sensitivity(run, RESPONSES[:5], names)
    rest = []
    for size in (1e-2, 5e-3, 2.5e-3):
        moved = dict(zip(names, at + size * change, strict=True))
        there = values(*again(run.system, run.steps, METHODS["HHT"], moved), RESPONSES[:5])
        rest.append(abs(there - gradient.values - size * gradient.matrix @ change))
    slopes = np.log2(np.array(rest[:-1]) / np.array(rest[1:]))
    assert np.all(abs(slopes - 2) < 0.1), slopes


EXTREMES = [sr.Maximum("slider.velocity.x"), sr.Minimum("slider.velocity.x"), sr.Maximum("pin.force.z")]


def test_an_extreme_between_steps_has_the_derivatives_of_its_value() -> None:
    """Those of the number that is told, with one weight for each of three nodes."""
    run = sr.simulate(slider_crank(), until=1.5, store="steps", method=sr.HHT(rtol=1e-5, atol=1e-7))
    run = solved(run, sr.HHT())
    found = sr.sensitivity(run, EXTREMES, ["spring.k"]).matrix[:, 0]
    assert found == pytest.approx(differenced(run, EXTREMES, "spring.k", 1e-3, sr.HHT()), rel=2e-5)


def test_the_derivative_of_an_extreme_converges_with_the_square_of_the_step() -> None:
    """To those of the motion, found by DOP853 to twelve digits: the extreme's time must converge, too.

    With 1e-9, what Newton's method leaves would be as large as the error of the shortest steps.
    """
    wanted, errors = np.array([0.01429149, -0.00728181]), []
    for h in (4e-3, 1e-3, 5e-4):
        run = sr.simulate(slider_crank(), until=1.5, store="steps", method=sr.HHT(step=h, rtol=1e-11))
        errors.append(abs(sr.sensitivity(run, EXTREMES[:2], ["spring.k"]).matrix[:, 0] - wanted).max())
    assert errors[0] > 4 * errors[1], errors
    assert errors[0] > 64 * errors[2], errors
    assert errors[2] < 2e-8


def test_state_derivatives_satisfy_the_differentiated_constraints() -> None:
    run, system = swung("HHT"), slider_crank()
    found = sr.state_derivatives(run, ["spring.k", "rod.mass", "crank.angular_velocity.x"])
    for n in (0, 5, -1):
        change = system.Phi_q(run.steps.q[n]) @ found.q_b[n]
        assert abs(change).max() < 1e-11 * max(1.0, abs(found.q_b[n]).max())


def test_an_angle_at_one_time_has_all_its_turns() -> None:
    wheel = sr.Body("wheel", mass=1.0, inertia=(1, 1, 1), angular_velocity=(0, 0, 3.0))
    pin = sr.Revolute("pin", sr.ground, wheel, point=(0, 0, 0), axis=(0, 0, 1))
    run = sr.simulate(sr.System(sr.Model("wheel", [wheel], [pin])), until=5.0, store="steps")
    found = sr.sensitivity(
        run, [sr.At("pin.angle", time=t) for t in (0.5, 4.5)], ["wheel.angular_velocity.z"]
    )
    assert np.allclose(found.values, [1.5, 13.5], rtol=1e-4)
    assert np.allclose(found["wheel.angular_velocity.z"], [0.5, 4.5], rtol=1e-3)


def test_a_run_that_failed_is_refused() -> None:
    run = sr.simulate(slider_crank(), until=0.05, store="steps")
    failed = replace(run, success=False, message="steps become too small near t = 0.05 s")
    with pytest.raises(ValueError, match=r"reached its end, but .*steps become too small"):
        sr.sensitivity(failed, "slider.x")


def test_a_run_without_steps_is_refused() -> None:
    run = sr.simulate(slider_crank(), until=0.1)
    with pytest.raises(ValueError, match="store='steps'"):
        sr.sensitivity(run, "slider.x")


@pytest.mark.parametrize("wrong", ["slider.w", "pin.force", "pin.multiplier.9", "wheel.x", "spring.angle"])
def test_unknown_outputs_are_named(wrong: str) -> None:
    with pytest.raises(sr.SarrusError, match="no output"):
        sr.sensitivity(swung("HHT"), wrong)


def test_unknown_numbers_are_named() -> None:
    with pytest.raises(sr.SarrusError, match="Did you mean"):
        sr.sensitivity(swung("HHT"), "slider.x", ["spring.kk"])


def test_a_design_that_describes_another_model_is_refused() -> None:
    with pytest.raises(sr.SarrusError, match="but the model has 10"):
        sr.sensitivity(swung("HHT"), "slider.x", design={"s": 3.0}, formula=lambda d: {"spring.k": d["s"]})


def test_an_order_of_pivots_that_does_not_suit_is_chosen_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """That of a matrix of any numbers has pivots where there is nothing."""
    run, wanted = swung("HHT"), both("HHT")[1].matrix
    record, chosen, factors = Record(run.system, run.steps), [], []
    for one in record.operations:
        own = OperationMatrix(run.system, one.tables)
        own.numbers.values[:] = np.random.default_rng(1).normal(size=len(own.numbers.values))
        factors.append(own.arranged() if len(one) else None)
    order = factors, sweep.Sweep(record, len(RESPONSES))._blocks.matrices(factors)
    key = (*(len(one) > 0 for one in record.operations), False, False)
    monkeypatch.setitem(sweep.ORDERS, run.steps, {key: order})
    choose = sweep.Sweep._pivots
    monkeypatch.setattr(
        sweep.Sweep, "_pivots", lambda *at, **more: chosen.append(at[1:]) or choose(*at, **more)
    )
    found = sr.sensitivity(run, RESPONSES).matrix
    assert chosen
    assert (abs(found - wanted).max(axis=1) < 1e-10 * abs(wanted).max(axis=1)).all()
