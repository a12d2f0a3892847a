"""Arguments and outputs with units: what has one is converted, and other units are refused."""

from functools import cache
from typing import Any

import pytest

import sarrus as sr
from sarrus import mechanisms
from sarrus.outputs import UnknownOutput


@cache
def system() -> sr.System:
    return sr.System(sr.load(mechanisms.path("slider_crank")))


@cache
def run() -> sr.Trajectory:
    return sr.simulate(system(), until=0.1, store="steps")


def test_rates_have_units() -> None:
    given, plain = (
        sr.assemble(system(), rates={"pin.angle": rate}) for rate in ("90 deg/s", 1.5707963267948966)
    )
    assert given.v.tolist() == plain.v.tolist()
    assert given.asked is not None
    assert given.asked.rates == {"pin.angle": pytest.approx(1.5707963267948966)}
    with pytest.raises(
        sr.ModelError, match=r"rates: pin.angle must be in rad/s, or another unit of that kind"
    ):
        sr.assemble(system(), rates={"pin.angle": "3 m/s"})


def test_times_of_responses_have_units() -> None:
    assert sr.At("slider.x", time="50 ms").time == 0.05  # type: ignore[arg-type]
    with pytest.raises(sr.ModelError, match=r"time must be in s, or another unit of that kind"):
        sr.At("slider.x", time="3 kg")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"slider.x: time must be a number, got list"):
        sr.At("slider.x", time=[1.0])  # type: ignore[arg-type]


def test_bounds_and_scales_have_units() -> None:
    from sarrus.analyses.optimization.search import Variables

    found = Variables(["m"], sr.Problem(system(), "slider.x", ["crank.mass"], until=0.1).x0, {"m": ("1 g", "9 kg")},
                      {"m": "2 kg"}, ["kg"])  # fmt: skip
    assert found.limits.tolist() == [[0.001, 9.0]]
    assert found.scale.tolist() == [2.0]
    for bounds in (("1 m", "2 m"), (None, "3 s")):
        with pytest.raises(sr.ModelError, match=r"a bound of crank.mass must be"):
            sr.optimize(
                system(), sr.Final("slider.x"), ["crank.mass"], until=0.1, bounds={"crank.mass": bounds}
            )


def test_fixed_values_of_workspaces_have_units() -> None:
    arm = sr.Body("arm", 1.0, (1, 1, 1), position=(0.5, 0, 0))
    hand = sr.Body("hand", 1.0, (1, 1, 1), position=(1.5, 0, 0))
    joints = [
        sr.Revolute("shoulder", sr.ground, arm, point=(0, 0, 0), axis=(0, 0, 1)),
        sr.Revolute("elbow", arm, hand, point=(1, 0, 0), axis=(0, 0, 1)),
    ]
    system = sr.System(sr.Model("arm", [arm, hand], joints))
    with pytest.raises(
        sr.ModelError, match=r"fixed: shoulder.angle must be in rad, or another unit of that kind"
    ):
        sr.workspace_range(system, "hand.x", fixed={"shoulder.angle": "1 m"})
    given, plain = (
        sr.workspace_range(system, "hand.x", fixed={"shoulder.angle": x})
        for x in ("90 deg", 1.5707963267948966)
    )
    assert given.intervals == plain.intervals


def test_formulas_of_outputs_do_not_add_different_units() -> None:
    match = r"combines m and m s\^-1. Multiply one of them by a number, which may have any unit"
    for name in ("slider.x + slider.velocity.x", "max(slider.x, slider.velocity.x)"):
        with pytest.raises(UnknownOutput, match=match):
            run().output(name)
        with pytest.raises(UnknownOutput, match=match):
            sr.sensitivity(run(), sr.Final(name), ["crank.mass"])
    for name in ("slider.x + 0.1*slider.velocity.x", "slider.x - 0.1", "slider.x + 5 mm", "cos(9*slider.x)"):
        assert run().output(name).values.size


def test_a_unit_may_be_before_a_function() -> None:
    crank = sr.Body("crank", 1.0, (1, 1, 1))
    pin = sr.Revolute("pin", sr.ground, crank, point=(0, 0, 0), axis=(0, 0, 1))
    motor = sr.AngleDriver("motor", "pin", "30 deg*sin(2*t)")
    found = sr.kinematics(sr.System(sr.Model("crank", [crank], [pin], drivers=[motor])), [0.25])
    assert found["pin.angle"][0] == pytest.approx(0.5235987755982988 * 0.479425538604203)


MISTAKES: list[tuple[Any, type[Exception], str]] = [
    (lambda: sr.optimize(system(), "slider.x", untill=1), TypeError, "no argument .untill.. Did you mean .until."),
    (lambda: run().to_csv(), TypeError, "to_csv: path is missing"),
    (lambda: run().to_frame(["slider.x", "rod.x"]), TypeError, r"Give the names one by one, .* plot\(\*names\)"),
    (lambda: run().animate("film.html", traces="coupler"), TypeError, "traces must be a list of names"),
    (lambda: sr.describe(system()), sr.ModelError, "a system is made of a Model, .* Pass its model"),
    (lambda: sr.simulate(system(), until=0.1).sol(0.05), sr.ModelError, "and never of a saved run"),
]  # fmt: skip


@pytest.mark.parametrize(("call", "kind", "message"), MISTAKES)
def test_mistakes_have_a_remedy(call: Any, kind: type[Exception], message: str) -> None:
    with pytest.raises(kind, match=message):
        call()


def test_an_impact_along_the_time_is_refused() -> None:
    event = sr.Event("t - 0.05", reset=sr.Impact(0.5))
    with pytest.raises(
        sr.ModelError, match=r"the impact of the event t - 0.05 is along an output that no impulse changes"
    ):
        sr.simulate(system(), until=0.1, events=event)


def test_a_run_that_was_saved_afterwards_cannot_be_verified(tmp_path: Any) -> None:
    run().save(tmp_path / "run")
    with pytest.raises(sr.SarrusError, match=r"without its options and its steps. Simulate with save="):
        sr.verify(sr.load_run(tmp_path / "run"))
