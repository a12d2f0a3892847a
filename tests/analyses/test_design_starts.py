"""One start for simulations, searches, studies and uncertainty: assembled again for each design, or a fixed state."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import sarrus as sr
from sarrus import mechanisms
from sarrus.model.written import with_numbers
from sarrus.studies import Range, Simulation, study, uncertainty

G, MASS, INERTIA = 9.81, 2.0, 0.1
TIGHT: dict[str, Any] = {"method": sr.Radau(rtol=1e-9, atol=1e-11)}
RATES = {"rates": {"pin": 3.0}}
RATE = "rod.angular_velocity.y"


def pendulum(length: float = 0.5, k: float = 4.0) -> sr.System:
    """A rod at the horizontal, at rest, whose centre is at a length from the pin, with a rotational spring."""
    rod = sr.Body("rod", MASS, (INERTIA, INERTIA, INERTIA), position=(length, 0, 0))
    pin = sr.Revolute("pin", sr.ground, rod, point=(0, 0, 0), axis=(0, 1, 0))
    spring = sr.RSDA("spring", sr.ground, rod, k=k, point=(0, 0, 0), axis=(0, 1, 0))
    return sr.System(sr.Model("pendulum", [rod], [pin], [spring], gravity=(0, 0, -G)))


def swung(rate: float, seconds: float, length: float = 0.5, k: float = 4.0, angle: float = 0.0) -> np.ndarray:
    """Angle and rate of the same pendulum from its equation of motion, by SciPy."""

    def motion(t: float, y: np.ndarray) -> list[float]:
        moment = MASS * G * length * np.cos(y[0]) - k * y[0]
        return [y[1], moment / (INERTIA + MASS * length**2)]

    found = solve_ivp(motion, (0.0, seconds), [angle, rate], rtol=1e-11, atol=1e-12, method="DOP853")
    return np.asarray(found.y[:, -1])


def slope(value: Any, x: float, size: float) -> float:
    """The derivative by differences of fourth order."""
    h = 1e-3 * size
    f = [value(x + n * h) for n in (-2, -1, 1, 2)]
    return float((f[0] - 8 * f[1] + 8 * f[2] - f[3]) / (12 * h))


SYSTEM = pendulum()


def test_every_form_of_a_start_begins_the_runs_of_a_problem() -> None:
    """The values of a problem are those of a simulation from the same start, and that of SciPy."""
    assembly = sr.assemble(SYSTEM, rates={"pin": 3.0})
    run = sr.simulate(SYSTEM, assembly, until=0.4, **TIGHT)
    assert run.final is not None
    turned = sr.assemble(SYSTEM, rates={"pin": 0.0}, q=run.final.q).q
    starts: list[tuple[Any, float]] = [
        (assembly, 0.5), (RATES, 0.5), ({"rates": {"pin": "3 rad/s"}}, 0.5), (run.final, 0.9), (turned, 0.5),
        (sr.equilibrium(SYSTEM), 0.5), (None, 0.5),
    ]  # fmt: skip
    for start, until in starts:
        problem = sr.Problem(SYSTEM, sr.Final(RATE), ["spring.k"], until=until, start=start, **TIGHT)
        alone = sr.simulate(SYSTEM, start, until=until, **TIGHT)
        assert problem.values(problem.x0)[0] == pytest.approx(
            alone["rod"].angular_velocity_body[-1, 1], abs=1e-8
        )
    problem = sr.Problem(SYSTEM, sr.Final(RATE), ["spring.k"], until=0.5, start=RATES, **TIGHT)
    for k in (4.0, 5.0):
        assert problem.values(np.array([k]))[0] == pytest.approx(swung(3.0, 0.5, k=k)[1], abs=1e-6)
        by_k = slope(lambda x: swung(3.0, 0.5, k=x)[1], k, 1.0)
        assert problem.gradient(np.array([k])).matrix[0, 0] == pytest.approx(by_k, rel=1e-5)


@cache
def slider_crank() -> sr.System:
    return sr.System(sr.load(mechanisms.path("slider_crank")))


def test_a_start_with_rates_is_assembled_for_every_design_and_in_the_gradient() -> None:
    """Against models that are made, assembled and simulated one by one."""
    names = ["rod.mass", "pin.point.z", "spring.k"]
    assembly = sr.assemble(slider_crank(), rates={"pin": 2.0})
    problem = sr.Problem(slider_crank(), sr.Final("slider.x"), names, until=0.3, start=assembly, **TIGHT)

    def alone(n: int, x: float) -> float:
        values = problem.x0.copy()
        values[n] = x
        system = sr.System(with_numbers(slider_crank().model, dict(zip(names, values, strict=True))))
        start = sr.assemble(system, slider_crank().q0, rates={"pin": 2.0})
        run = sr.simulate(system, start, until=0.3, t_eval=[0.3], **TIGHT)
        return float(run.coordinate("slider.x")[-1])

    slopes = problem.gradient(problem.x0).matrix[0]
    for n, x in enumerate(problem.x0):
        moved = problem.x0.copy()
        moved[n] = 1.01 * x
        assert problem.values(moved)[0] == pytest.approx(alone(n, 1.01 * x), abs=1e-9)
        assert slopes[n] == pytest.approx(slope(lambda y, n=n: alone(n, y), x, x), rel=1e-5, abs=1e-8)


def test_a_fixed_state_is_refused_where_a_design_contradicts_it() -> None:
    state = sr.simulate(SYSTEM, RATES, until=0.4, **TIGHT).final
    assert state is not None
    with pytest.raises(
        sr.ModelError, match=r"start: pin.point.x changes constraints, but .* Pass sr.assemble"
    ):
        sr.Problem(SYSTEM, sr.Final("rod.x"), ["spring.k", "pin.point.x"], until=0.9, start=state)
    problem = sr.Problem(SYSTEM, sr.Final(RATE), ["spring.k"], until=0.9, start=state, **TIGHT)
    angle, rate = swung(3.0, 0.4)
    by_k = slope(lambda k: swung(rate, 0.5, k=k, angle=angle)[1], 4.0, 1.0)
    assert problem.gradient(problem.x0).matrix[0, 0] == pytest.approx(by_k, rel=1e-5)
    table = study(
        SYSTEM, {"pin.point.x": [0.0, 0.1]}, "rod.x", analysis=Simulation(0.9, start=state), workers=1
    )
    assert table.success.tolist() == [True, False]
    assert "has other constraints than the given state. Pass sr.assemble" in str(table.failures)


def test_searches_go_on_from_a_state_at_its_time() -> None:
    """The stiffness that brings the pendulum to what SciPy says of 5 N m, from a state at 0.4 s."""
    state = sr.simulate(SYSTEM, RATES, until=0.4, **TIGHT).final
    angle, rate = swung(3.0, 0.4)
    ends = [swung(rate, t - 0.4, k=5.0, angle=angle)[1] for t in (0.6, 0.9)]
    misfit = sr.Misfit(RATE, at=(0.6, 0.9), data=tuple(ends), sigma=1e-3)
    fitted = sr.fit(SYSTEM, misfit, ["spring.k"], start=state, **TIGHT)
    assert fitted.x == pytest.approx([5.0], rel=1e-4)

    def off(value: Any) -> Any:
        return (value - ends[1]) ** 2

    goal = sr.Combined(off, [sr.Final(RATE)])
    found = sr.optimize(
        SYSTEM, goal, ["spring.k"], until=0.9, start=state, bounds={"spring.k": (3, 8)}, **TIGHT
    )
    assert found.x == pytest.approx([5.0], rel=1e-3)
    several = sr.optimize(
        SYSTEM, goal, ["spring.k"], until=0.9, start=state, bounds={"spring.k": (3, 8)}, starts=2, **TIGHT
    )
    assert several.x == pytest.approx([5.0], rel=1e-3)


RESPONSES = {
    "end": RATE, "mean": f"mean({RATE})", "rms": f"rms({RATE})", "gain": f"final({RATE}) - initial({RATE})"
}  # fmt: skip


@pytest.mark.parametrize("kind", ["rates", "state"])
def test_studies_and_uncertainty_begin_where_they_are_told(kind: str) -> None:
    state = sr.simulate(SYSTEM, RATES, until=0.4, **TIGHT).final
    start, begin, seconds = (
        (RATES, (0.0, 3.0), 0.9) if kind == "rates" else (state, tuple(swung(3.0, 0.4)), 0.5)
    )
    run = Simulation(0.9, steps=4000, start=start, **TIGHT)
    table = study(SYSTEM, {"spring.k": [3.9, 4.1]}, RESPONSES, analysis=run, workers=1)
    for k, end, gain in zip((3.9, 4.1), table["end"], table["gain"], strict=True):
        wanted = swung(begin[1], seconds, k=k, angle=begin[0])[1]
        assert (end, gain) == pytest.approx((wanted, wanted - begin[1]), abs=1e-6)
    found = uncertainty(SYSTEM, {"spring.k": Range(3.9, 4.1)}, RESPONSES, analysis=run)
    assert found.matrix[:, 0] == pytest.approx((table.found[1] - table.found[0]) / 0.2, rel=2e-3)
    assert found.values == pytest.approx(table.found.mean(axis=0), abs=1e-3)
    if kind == "state":
        with pytest.raises(sr.ModelError, match=r"start: pin.point.x changes constraints"):
            uncertainty(SYSTEM, {"pin.point.x": Range(0, 0.1)}, "rod.x", analysis=run)
        with pytest.raises(sr.SarrusError, match=r"times must be between 0.4 and 0.9 s.* but one is 0.2"):
            study(SYSTEM, {"spring.k": [4]}, "at(rod.x, 0.2)", analysis=run)


def test_what_contradicts_a_start_is_refused() -> None:
    run = Simulation(0.5, start=RATES)
    with pytest.raises(sr.SarrusError, match=r"start.q.rod.r.x varies the model's own initial state"):
        study(SYSTEM, {"start.q.rod.r.x": [0.4]}, "rod.x", analysis=run)
    late = sr.assemble(SYSTEM, t=2.0)
    with pytest.raises(ValueError, match="until must be a time in s after the start at 2"):
        study(SYSTEM, {"spring.k": [4]}, "rod.x", analysis=Simulation(0.5, start=late))
    for wrong, message in (
        (
            {"rates": {"pin": "5 m/s"}},
            "start: pin must be in rad/s, or another unit of that kind, got .5 m/s.",
        ),
        ({"rates": {"pim": 5}}, "start: pendulum has no output 'pim'. Choose from pin.angle"),
        ({"rates": {"pin": np.nan}}, "start: rates: pin must be a finite number"),
        ({"run": "nowhere"}, "nowhere"),
        ({"run": "x", "rates": {}}, "run and rates contradict each other"),
    ):
        with pytest.raises(sr.SarrusError, match=message):
            sr.Problem(SYSTEM, sr.Final("rod.x"), ["spring.k"], until=0.5, start=wrong)
    with pytest.raises(TypeError, match=r"Give run.final or run.state\(t\)"):
        sr.optimize(SYSTEM, sr.Final("rod.x"), ["spring.k"], until=0.5, start=sr.simulate(SYSTEM, until=0.1))


def test_a_saved_run_is_a_start(tmp_path: Path) -> None:
    sr.simulate(SYSTEM, RATES, until=0.4, t_eval=[0.2, 0.4], save=tmp_path / "run.sarrus", **TIGHT)
    for given, begin in (({}, 0.4), ({"t": 0.2}, 0.2)):
        run = sr.simulate(SYSTEM, {"run": tmp_path / "run.sarrus", **given}, until=0.9, **TIGHT)
        assert run.t[0] == begin
        assert run["rod"].angular_velocity_body[-1, 1] == pytest.approx(swung(3.0, 0.9)[1], abs=1e-6)
    with pytest.raises(sr.ModelError, match=r"no state was stored at t = 0.3 s"):
        sr.simulate(SYSTEM, {"run": tmp_path / "run.sarrus", "t": 0.3}, until=0.9)


def test_the_start_of_a_study_is_part_of_its_folder(tmp_path: Path) -> None:
    def table(start: Any) -> Any:
        run = Simulation(0.2, steps=10, start=start)
        return study(SYSTEM, {"spring.k": [4.0]}, RATE, analysis=run, workers=1, folder=tmp_path / "study")

    first = table(RATES)
    assert table(sr.assemble(SYSTEM, rates={"pin": 3.0})).found == pytest.approx(first.found)
    with pytest.raises(sr.SarrusError):
        table({"rates": {"pin": 4.0}})


def test_a_start_at_another_place_keeps_it_in_every_design() -> None:
    """A guess of its own, by coordinates, in place of the model's: the pendulum at 0.5 rad."""
    q = pendulum().q0.copy()
    half = 0.25
    q[:3] = 0.5 * np.cos(0.5), 0.0, -0.5 * np.sin(0.5)
    q[3:] = np.cos(half), 0.0, np.sin(half), 0.0
    problem = sr.Problem(SYSTEM, sr.Final(RATE), ["spring.k"], until=0.5, start=q, **TIGHT)
    for k in (4.0, 5.0):
        assert problem.values(np.array([k]))[0] == pytest.approx(swung(0.0, 0.5, k=k, angle=0.5)[1], abs=1e-6)


def test_held_coordinates_stay_held() -> None:
    """The carriage of an assembly that holds it does not move, whatever the design."""
    model = slider_crank().model
    held = sr.assemble(slider_crank(), fixed=["crank"])
    problem = sr.Problem(
        slider_crank(),
        [sr.At(name, time=0.0) for name in ("crank.y", "slider.x")],
        ["guide.point.z"],
        until=0.01,
        start=held,
    )
    moved = problem.values(problem.x0 + 0.1)
    alone = sr.assemble(
        sr.System(with_numbers(model, {"guide.point.z": 0.1})), slider_crank().q0, fixed=["crank"]
    )
    assert moved[0] == slider_crank().q0[1] == alone.q[1]
    assert moved[1] == pytest.approx(alone.q[14], abs=1e-12)


def test_uncertainty_says_what_assembly_changes_as_studies_do() -> None:
    """A rod that is drawn 0.1 m off its pin."""
    model = pendulum().model
    places = ((sr.ground, 0.0), (model.bodies[0], -0.4))
    at, own = (body.frame((x, 0, 0), x=(1, 0, 0), z=(0, 1, 0)) for body, x in places)
    off = sr.Revolute("pin", frame_i=at, frame_j=own)
    moved = sr.Model("off", model.bodies, [off], model.forces, gravity=model.gravity)
    for call in (study, uncertainty):
        with pytest.warns(sr.SarrusWarning, match="assembly changed the given initial state: rod: position"):
            call(moved, {"spring.k": Range(3.9, 4.1, 2)}, RATE, analysis=Simulation(0.1, steps=5))
