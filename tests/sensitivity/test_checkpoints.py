"""Gradients by checkpoints are those of runs whose steps are all kept, to the last bits."""

import gc
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from tests.sensitivity.checkpoints import by_checkpoints
from tests.sensitivity.test_curves import NAMES, arm
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.sensitivity import Response, long_run
from sarrus.results import StepsTaken

LOOSE = {"rtol": 1e-5, "atol": 1e-7}
SETTINGS = {"method": sr.Radau(**LOOSE)}
RESPONSES = [
    sr.Final("slider.x"),
    sr.Final("pin.angle"),
    sr.Integral("energy.kinetic"),
    sr.At("spring.length", time=0.33),
    sr.Maximum("slider.velocity.x"),
    sr.Misfit("slider.x", at=(0.1, 0.2, 0.75), data=(1.0, 1.1, 1.2)),
    sr.Integral(lambda o: o.parameter("spring.k") * o("slider.x"), name="own"),
]


def compared(
    system: sr.System,
    responses: object,
    until: float,
    names: list[str] | None = None,
    memory: float = 100e6,
    limit: float = 1e-12,
    **settings: object,
) -> None:
    """By checkpoints and by all steps."""
    run = sr.simulate(system, until=until, store="steps", **settings)
    wanted = sr.sensitivity(run, responses, names)
    settings |= {"until": until, "memory": memory}
    found = by_checkpoints(system, responses, names, **settings)
    assert found.responses == wanted.responses
    assert found.names == wanted.names
    assert np.allclose(found.values, wanted.values, rtol=1e-13, atol=0)
    for row, whole in zip(found.matrix, wanted.matrix, strict=True):
        assert abs(row - whole).max() < limit * abs(whole).max()  # sums in another order


@pytest.mark.one_in(4)
@pytest.mark.parametrize("first", [7, 400])
@pytest.mark.parametrize("method", [sr.HHT(), sr.Radau()])
def test_the_gradient_is_that_of_all_steps(
    method: object, first: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(long_run, "FIRST", first)
    compared(slider_crank(), RESPONSES, 0.8, method=replace(method, **LOOSE))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:load. its table ends at 0 and 1.2")
@pytest.mark.parametrize("method", [sr.HHT(), sr.Radau()])
def test_turns_and_numbers_of_tables(method: object, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(long_run, "FIRST", 3)
    responses = ["pin.angle", sr.Integral("elbow.angle"), sr.Minimum("tip.x")]
    limit = 1e-10  # steps that end where parts of the table do are short, which magnifies round-off
    compared(sr.System(arm()), responses, 4.0, names=NAMES, limit=limit, method=replace(method, **LOOSE))


def test_checkpoints_are_dropped_where_they_need_more_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(long_run, "FIRST", 2)
    begun: list[int] = []
    take = long_run.LongRun.interval
    monkeypatch.setattr(
        long_run.LongRun, "interval", lambda self, n: begun.append(len(self)) or take(self, n)
    )
    compared(slider_crank(), RESPONSES[0], 0.8, memory=6e5, **SETTINGS)
    assert 1 < begun[0] < 20


def test_too_little_memory_is_told() -> None:
    with pytest.raises(ValueError, match=r"too few at t = .* give more than memory="):
        by_checkpoints(slider_crank(), "slider.x", until=0.8, memory=1e5)


def test_runs_that_come_to_nothing_are_refused() -> None:
    for until in (-1.0, np.nan):
        with pytest.raises(ValueError, match="until must be a"):
            by_checkpoints(slider_crank(), "slider.x", until=until)
    with pytest.raises(ValueError, match="max_step must be a positive"):
        by_checkpoints(slider_crank(), "slider.x", until=1.0, method=sr.Radau(max_step=-1.0))
    ball = sr.Body("ball", mass=1.0, inertia=(1.0, 1.0, 1.0))
    load = sr.PointForce("load", ball.point(0, 0, 0), force=(1, 0, 0), factor=lambda t: 1 / (0.5 - t) ** 2)
    system = sr.System(sr.Model("blown", bodies=[ball], forces=[load]))
    with pytest.raises(ValueError, match="reached its end, but blown: "):
        by_checkpoints(system, "ball.x", until=1.0)


def test_no_steps_are_left_for_the_garbage_collector(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of all intervals would stay in memory until it runs."""
    monkeypatch.setattr(long_run, "FIRST", 7)

    def count() -> int:
        return sum(type(x) is StepsTaken for x in gc.get_objects())

    system, given = slider_crank(), {"until": 0.4, "method": sr.HHT(**LOOSE)}
    gc.collect()
    before = count()
    gc.disable()
    try:
        by_checkpoints(system, "slider.x", ["spring.k"], **given)
        assert count() == before
    finally:
        gc.enable()


def test_the_former_spelling_has_the_same_gradient() -> None:
    asked = {"until": 0.4, **SETTINGS}
    found = by_checkpoints(slider_crank(), "slider.x", ["spring.k"], **asked)
    with pytest.warns(DeprecationWarning, match=r"Use sensitivity\(simulate\(...\), ..., memory=\)"):
        former = sr.sensitivity_by_checkpoints(slider_crank(), "slider.x", ["spring.k"], **asked)
    assert np.array_equal(former.matrix, found.matrix)


def test_a_run_and_a_saved_one_are_repeated(tmp_path: Path) -> None:
    """The options of the run are those of its call, or of its folder."""
    system, given = (
        slider_crank(),
        {"until": 0.4, "method": sr.Radau(max_step=0.01, **LOOSE), "events": [0.11]},
    )
    stored = sr.sensitivity(sr.simulate(system, store="steps", **given), "slider.x", ["spring.k"])
    sr.simulate(system, save=tmp_path / "run", **given)
    for run in (sr.simulate(system, **given), sr.load_run(tmp_path / "run", system)):
        found = sr.sensitivity(run, "slider.x", ["spring.k"], memory="50 MB")
        np.testing.assert_allclose(found.matrix, stored.matrix, rtol=1e-12)


def test_what_cannot_be_repeated_is_refused() -> None:
    run = sr.simulate(slider_crank(), until=0.1)
    with pytest.raises(ValueError, match="memory= repeats a run of simulate, without controllers"):
        sr.sensitivity(replace(run, call=None), "slider.x", memory=1e6)
    for more in ({"method": "direct"}, {"error": True}):
        with pytest.raises(ValueError, match='memory= needs method="adjoint", and error=False'):
            sr.sensitivity(run, "slider.x", memory=1e6, **more)
    with pytest.raises(sr.SarrusError, match='Give one, or a text such as "500 MB"'):
        sr.sensitivity(run, "slider.x", memory="much")
    ode = sr.simulate(slider_crank(), until=0.1, method=sr.ODE())
    with pytest.raises(TypeError, match="method must be HHT"):
        sr.sensitivity(ode, "slider.x", memory=1e6)


@dataclass(frozen=True, eq=False)
class SquareIntegral(Response):
    """∫ g² dt."""

    pointwise = False
    additive = True

    def value(self, g: np.ndarray, t: np.ndarray) -> float:
        return float(self.layout.weights(t) @ g**2)

    def weights(self, g: np.ndarray, t: np.ndarray) -> np.ndarray:
        return 2 * self.layout.weights(t) * g


class Root(SquareIntegral):
    """Of it, which is no sum over time."""

    additive = False


def test_responses_of_users_are_sums_over_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(long_run, "FIRST", 7)
    compared(
        slider_crank(), SquareIntegral("slider.velocity.x"), 0.4, ["spring.k", "slider.mass"], **SETTINGS
    )
    with pytest.raises(
        ValueError, match=r"root of slider.x: memory= needs responses that are sums over time"
    ):
        by_checkpoints(slider_crank(), Root("slider.x"), until=0.1)
