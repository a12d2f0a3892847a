"""Loads that are switched on and off: stored steps end there, as those of other runs do."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.sensitivity.test_checkpoints import compared
from tests.sensitivity.test_corners import sprung

import sarrus as sr
from sarrus.analyses.dynamics.time_loop import recording

ON, OFF, T = 1.2345, 2.0, 3.0
METHODS: dict[str, Any] = {
    "HHT": sr.HHT(step=1e-2),
    "generalized-alpha": sr.GeneralizedAlpha(step=1e-2),
    "stabilized": sr.HHT(step=1e-2, stabilized=True),
}


TABLES = {
    "cubics": sr.Curve((0.0, ON, OFF, 4.0), tuple((0.0, 0.0, 0.0, value) for value in (0.0, 10.0, 0.0))),
    "spline": sr.Curve.table([(0, 0), (0.5, 3), (ON, -2), (OFF, 5), (T, 1)]),
    "straight": sr.Curve.table([(0, 0), (ON, 5)]),
}


def switched(k: float = 40.0, through: str = "step") -> sr.System:
    """A mass on a spring, with a load of 10 N between two times."""
    body = sr.Body("b", mass=1.0, inertia=(0.1,) * 3)
    slide = sr.Translational("g", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("s", sr.ground.point(-5, 0, 0), body.point(0, 0, 0), k=k, c=0.1, length=5)
    laws = {
        "step": f"10*(step(t - {ON}) - step(t - {OFF}))",
        "sign": f"5*(sign(t - {ON}) - sign(t - {OFF}))",
    }
    if through in laws:
        load = sr.Force("f", joint="g", value=laws[through])
    else:
        load = sr.Force("f", joint="g", value=TABLES[through], over="t")
    return sr.System(sr.Model("m", [body], [slide], [spring, load], gravity=(0, 0, 0)))


def closed_form(k: float) -> float:
    """x at T: two responses to a step."""
    damping = 0.05
    w = np.sqrt(k - damping**2)

    def after(t: float) -> float:
        return 10 / k * (1 - np.exp(-damping * t) * (np.cos(w * t) + damping / w * np.sin(w * t)))

    return float(after(T - ON) - after(T - OFF))


def run(k: float, method: Any, through: str = "step", stored: bool = True) -> sr.Trajectory:
    return sr.simulate(switched(k, through), until=T, method=method, store="steps" if stored else "samples")


@pytest.mark.one_in(4)
@pytest.mark.parametrize("through", ["step", "sign", "cubics"])
@pytest.mark.parametrize("method", METHODS)
def test_stored_steps_are_those_of_other_runs(method: str, through: str) -> None:
    stored, plain = (
        run(40, METHODS[method], through, stored)["b"].position[-1, 0] for stored in (True, False)
    )
    assert stored == pytest.approx(plain, abs=1e-12)
    assert stored == pytest.approx(closed_form(40), abs=2e-3)


@pytest.mark.parametrize("through", ["step", "cubics"])
def test_the_error_falls_with_the_square_of_the_step(through: str) -> None:
    """Without a new start behind the jumps it falls with the step only."""
    errors = [
        abs(run(40, sr.HHT(step=h, alpha=0.0), through)["b"].position[-1, 0] - closed_form(40))
        for h in (1e-2, 5e-3)
    ]
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.1)


@pytest.mark.parametrize("method", METHODS)
def test_gradients_are_those_of_the_computed_motion(method: str) -> None:
    h, response = 1e-3, sr.Final("b.x")
    found = sr.sensitivity(run(40, METHODS[method]), response, ["s.k"])
    ends = [run(k, METHODS[method])["b"].position[-1, 0] for k in (40 + h, 40 - h)]
    assert found.matrix[0, 0] == pytest.approx((ends[0] - ends[1]) / (2 * h), rel=1e-6)
    direct = sr.sensitivity(run(40, METHODS[method]), response, ["s.k"], method="direct")
    assert direct.matrix[0, 0] == pytest.approx(found.matrix[0, 0], rel=1e-10)


@pytest.mark.one_in(4)
@pytest.mark.filterwarnings("ignore:.*spline through the table")
@pytest.mark.filterwarnings("ignore:f. its table ends at")
@pytest.mark.parametrize("method", [METHODS["HHT"], sr.Radau()])
@pytest.mark.parametrize("table", TABLES)
def test_gradients_of_motions_by_tables_over_time(table: str, method: Any) -> None:
    h, stored = 1e-3, run(40, method, table)
    plain = run(40, method, table, stored=False)["b"].position[-1, 0]
    assert stored["b"].position[-1, 0] == pytest.approx(
        plain, abs=1e-6
    )  # not stored, HHT starts anew at bends, too
    ends = [run(k, method, table)["b"].position[-1, 0] for k in (40 + h, 40 - h)]
    found = sr.sensitivity(stored, sr.Final("b.x"), ["s.k"]).matrix[0, 0]
    assert found == pytest.approx((ends[0] - ends[1]) / (2 * h), rel=1e-6)


def test_second_derivatives() -> None:
    h = 1e-2
    found = sr.hessian(run(40, METHODS["HHT"]), sr.Final("b.x"), ["s.k"])
    slopes = [
        sr.sensitivity(run(k, METHODS["HHT"]), sr.Final("b.x"), ["s.k"]).matrix[0, 0]
        for k in (40 + h, 40 - h)
    ]
    assert float(np.ravel(found.matrix)[0]) == pytest.approx((slopes[0] - slopes[1]) / (2 * h), rel=1e-4)


def test_checkpoints_are_between_the_same_steps() -> None:
    compared(switched(), [sr.Final("b.x"), sr.Integral("b.x")], T, ["s.k"], method=sr.HHT())


def test_the_error_estimate() -> None:
    found = run(40, sr.HHT(step=1e-2))
    true = abs(found["b"].position[-1, 0] - closed_form(40))
    assert 0.3 * true < found.error("b.x").error < 3 * true


@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", METHODS)
def test_saved_runs_keep_the_steps_before_jumps(method: str, tmp_path: Path) -> None:
    settings: dict[str, Any] = {"until": T, "method": METHODS[method], "store": "steps"}
    saved = sr.simulate(switched(), save=tmp_path / "run", **settings)
    wanted = all_of(run(40, METHODS[method]))
    for one in (saved, sr.resume(tmp_path / "run"), sr.repeat(tmp_path / "run")):
        assert one.steps is not None
        assert one.steps.t[0] == 0
        np.testing.assert_array_equal(all_of(one), wanted)


def all_of(one: sr.Trajectory) -> list[float]:
    """Derivatives by both methods, and an estimate of an error."""
    responses = [sr.Final("b.x"), sr.Integral("b.x")]
    found = [sr.sensitivity(one, responses, ["s.k"], method=by).matrix for by in ("adjoint", "direct")]
    return [*np.ravel(found), one.error("b.x").error]


@pytest.mark.one_in(4)
@pytest.mark.parametrize("stop", [1.0, 1.5, 2.5])
def test_continued_runs_keep_them(stop: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stopped before and behind the jumps, with a mark after every chunk of steps."""
    monkeypatch.setattr(recording, "PAUSE", 0.0)
    monkeypatch.setattr(recording, "PATIENT", 0.0)

    def interrupt(t: float) -> None:
        if t >= stop:
            raise KeyboardInterrupt

    settings: dict[str, Any] = {"until": T, "method": sr.HHT(step=5e-3), "store": "steps"}
    cut = sr.simulate(switched(), save=tmp_path / "run", progress=interrupt, **settings)
    assert cut.status == "stopped"
    whole = sr.simulate(switched(), **settings)
    np.testing.assert_array_equal(all_of(sr.resume(tmp_path / "run")), all_of(whole))
    np.testing.assert_array_equal(all_of(sr.resume(tmp_path / "run")), all_of(whole))


KINKED = sprung(k="40 + 60*max(x - 2.05, 0)")
OWN = {"jump": (switched, 1.6, sr.HHT()), "corner of spring": (lambda: KINKED, 0.3, sr.Radau())}


@pytest.mark.parametrize("own", OWN)
def test_jumps_and_corners_are_no_events_of_the_user(own: str) -> None:
    """Their names are free, and only a user's names are known."""
    (system, until, method), response = OWN[own], sr.AtEvent("t", event=own)
    settings: dict[str, Any] = {"until": until, "method": method, "store": "steps"}
    unused = sr.simulate(system(), **settings)
    assert [one.name for one in unused.steps.event_steps] == [own]
    with pytest.raises(ValueError, match=f"0 events '{own}' .*; it has none"):
        sr.sensitivity(unused, response, ["b.mass"])
    late = 0.9 * until
    event = sr.Event(f"t - {late}", name=own, reset=lambda t, q, v: v)
    used = sr.simulate(system(), events=event, **settings)
    assert sr.sensitivity(used, response, ["b.mass"]).values[0] == pytest.approx(late, rel=1e-12)


def begun(law: str, method: Any, **settings: Any) -> sr.Trajectory:
    """The mass at rest, with a load from the start on."""
    model = switched().model
    load = sr.Force("f", joint="g", value=law)
    system = sr.System(replace(model, forces=[model.forces[0], load]))
    return sr.simulate(system, until=1.0, method=method, store="steps", **settings)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", [METHODS["HHT"], sr.HHT()])
@pytest.mark.parametrize("law", ["10*step(t)", "5 + 5*sign(t)", "10*step(t - 1e-13)"])
def test_a_jump_at_the_start_is_before_the_first_step(law: str, method: Any, tmp_path: Path) -> None:
    """Its accelerations are those of the load that acts from there on; the motion is known from the start itself."""
    found = begun(law, method, save=tmp_path / "run")
    wanted = begun("10", method)
    assert not found.warnings
    assert found["b.x"][-1] == pytest.approx(wanted["b.x"][-1], abs=1e-11)
    assert found.sol(0.0).q[0] == sr.resume(tmp_path / "run").sol(0.0).q[0] == 0
    responses = [sr.At("b.x", time=0.0), sr.Final("b.x"), sr.Integral("b.x")]
    matrices = [sr.sensitivity(one, responses, ["s.k"]).matrix for one in (found, wanted)]
    np.testing.assert_allclose(*matrices, rtol=1e-8, atol=1e-12)


def test_derivatives_by_the_height_of_a_jump_at_the_start() -> None:
    """The motion is proportional to it."""
    found = sr.sensitivity(begun("10*step(t)", METHODS["HHT"]), sr.Final("b.x"), ["f.value.1"])
    assert found.matrix[0, 0] == pytest.approx(found.values[0] / 10, rel=1e-9)
