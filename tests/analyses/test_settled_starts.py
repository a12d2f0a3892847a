"""Settle first, then drive: the equilibrium of every design as a start, with derivatives that go through it."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.sensitivity.checkpoints import by_checkpoints

import sarrus as sr
from sarrus.model.written import with_numbers, written_numbers
from sarrus.studies import Range, Simulation, Statics, study, uncertainty
from sarrus.studies.file import read_study_file
from sarrus.studies.optimization import read_optimization_file

TIGHT: dict[str, Any] = {"method": sr.Radau(rtol=1e-10)}
SETTLED = {"equilibrium": True}
DRIVEN = {"equilibrium": True, "rates": {"pin": 2.0}}
NAMES = ["spring.k", "rod.mass", "pin.point.z", "spring.length", "gravity.z"]
BASE = sr.load("slider_crank")


@cache
def rest() -> sr.Equilibrium:
    return sr.equilibrium(sr.System(BASE))


def start_of(system: sr.System, rate: float | None) -> sr.Assembly:
    """The start by two analyses in turn, near the equilibrium of the model as it is."""
    settled = sr.equilibrium(system, rest().q)
    assert settled.success
    rates = {} if rate is None else {"pin": rate}
    return sr.assemble(system, settled.q, np.zeros(system.nq), rates=rates)


def end(rate: float | None, values: dict[str, float]) -> float:
    """The end of a motion of a model with other numbers, of which nothing is differentiated."""
    system = sr.System(with_numbers(BASE, values))
    run = sr.simulate(system, start_of(system, rate), until=0.3, t_eval=[0.3], **TIGHT)
    return float(run.coordinate("slider.x")[-1])


def slope(value: Callable[[float], float], x: float, size: float) -> float:
    """The derivative by differences of fourth order."""
    h = 1e-4 * size
    f = [value(x + n * h) for n in (-2, -1, 1, 2)]
    return float((f[0] - 8 * f[1] + 8 * f[2] - f[3]) / (12 * h))


def test_velocities_that_a_rate_does_not_determine_follow_the_equilibrium() -> None:
    """Of two pendulums one rate is given: the least change depends on the size of the model, and on its equilibrium."""
    upper = sr.Body("upper", 2.0, (0.02, 0.18, 0.19), (0.5, 0, -0.1))
    lower = sr.Body("lower", 1.5, (0.015, 0.09, 0.1), (1.3, 0, -0.2))
    joints = [
        sr.Revolute("shoulder", sr.ground, upper, point=(0, 0, 0), axis=(0, 1, 0)),
        sr.Revolute("elbow", upper, lower, point=(1, 0, 0), axis=(0, 1, 0)),
    ]
    springs = [
        sr.TSDA("spring", sr.ground.point(0.3, 0, 0.9), lower.point(0.1, 0, 0.05), k=30.0, length=0.7),
        sr.TSDA("other", sr.ground.point(-0.3, 0, 0.9), upper.point(0.1, 0, 0.05), k=60.0, length=0.4),
    ]
    model = sr.Model("two", [upper, lower], joints, springs, gravity=(0, 0, -9.81))
    start, names = {"equilibrium": True, "rates": {"lower.z": 0.3}}, ["spring.k", "elbow.point.x"]

    def gradient(values: dict[str, float]) -> sr.Sensitivity:
        run = sr.simulate(sr.System(with_numbers(model, values)), start, until=0.02, store="steps", **TIGHT)
        return sr.sensitivity(run, sr.Final("lower.velocity.x"), names)

    own, found = written_numbers(model), gradient({})
    wanted = [slope(lambda x, n=n: float(gradient({n: x}).values[0]), own[n], 1 + own[n]) for n in names]  # type: ignore[misc]
    assert found.matrix[0] == pytest.approx(wanted, rel=1e-6)
    run = sr.simulate(sr.System(model), start, until=0.02, store="steps", **TIGHT)
    second = sr.hessian(run, sr.Final("lower.velocity.x"), names)
    bends = [slope(lambda x: float(gradient({names[1]: x}).matrix[0, n]), own[names[1]], 1.0) for n in (0, 1)]  # noqa: B023
    assert second.matrix[1] == pytest.approx(bends, rel=1e-5)


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("make", "rate"), [(rest, None), (lambda: SETTLED, None), (lambda: DRIVEN, 2.0)])
def test_gradients_go_through_the_equilibrium(make: Callable[[], Any], rate: float | None) -> None:
    start = make()
    run = sr.simulate(sr.System(BASE), start, until=0.3, store="steps", **TIGHT)
    assert run.steps.start.settled
    own = written_numbers(BASE)
    wanted = [slope(lambda x, n=n: end(rate, {n: x}), own[n], abs(own[n]) or 1.0) for n in NAMES]  # type: ignore[misc]
    backward = sr.sensitivity(run, sr.Final("slider.x"), NAMES)
    forward = sr.state_derivatives(run, NAMES)
    assert backward.matrix[0] == pytest.approx(wanted, rel=1e-6)
    place = run.system.coordinate_names.index("slider.r.x")
    assert forward.q_b[-1, place] == pytest.approx(wanted, rel=1e-6)
    assert by_checkpoints(
        run.system, sr.Final("slider.x"), until=0.3, wrt=NAMES, start=start, **TIGHT
    ).matrix[0] == pytest.approx(wanted, rel=1e-6)


def hanging(k: Any = 40.0, push: float = 0.7, mass: float = 1.5) -> sr.System:
    """A rod on a pin with a follower force, which has no potential, and a coil with a nonlinear law."""
    rod = sr.Body("rod", mass, (0.1, 0.1, 0.1), position=(0.5, 0, 0))
    about = {"point": (0, 0, 0), "axis": (0, 1, 0)}
    pin = sr.Revolute("pin", sr.ground, rod, **about)
    coil = sr.RSDA("coil", sr.ground, rod, k=k, c=0.1, **about)
    jet = sr.PointForce("jet", rod.point(0.3, 0, 0), (0.2, 0, push), axes="body")
    wind = sr.PointForce("wind", rod.point(0.1, 0, 0.2), (0, 0, "1 + 0.5*t"))
    return sr.System(sr.Model("hanging", [rod], [pin], [coil, jet, wind], gravity=(0, 0, -9.81)))


@pytest.mark.slow
@pytest.mark.parametrize("law", ["40 + 30*x**2", [[-3, 60], [-1, 45], [0, 40], [1, 50], [3, 70]]])
def test_laws_and_forces_without_a_potential(law: Any) -> None:
    system = hanging(law)
    names = [
        name for name in written_numbers(system.model) if name.startswith(("coil.k", "jet.force", "rod.mass"))
    ]
    run = sr.simulate(system, {"equilibrium": True, "rates": {"pin": 1.0}}, until=0.4, store="steps", **TIGHT)
    found = sr.sensitivity(run, sr.Final("rod.x"), names).matrix[0]
    first = sr.equilibrium(system)

    def value(name: str, x: float) -> float:
        other = sr.System(with_numbers(system.model, {name: x}))
        rest = sr.equilibrium(other, first.q)
        begin = sr.assemble(other, rest.q, np.zeros(7), rates={"pin": 1.0})
        return float(sr.simulate(other, begin, until=0.4, t_eval=[0.4], **TIGHT).coordinate("rod.x")[-1])

    own = written_numbers(system.model)
    wanted = [slope(lambda x, n=n: value(n, x), own[n], abs(own[n]) or 1.0) for n in names]  # type: ignore[misc]
    assert np.max(np.abs(wanted)) > 1e-3
    assert found == pytest.approx(wanted, rel=2e-6, abs=1e-9)


def bends(base: sr.Model, start: Any, until: float, response: Any, names: list[str]) -> np.ndarray:
    """Second derivatives by differences of gradients of other models, which settle and move by themselves."""
    own, rows = written_numbers(base), []
    for name in names:
        h = 1e-4 * (abs(own[name]) or 1.0)
        found = []
        for n in (-2, -1, 1, 2):
            other = sr.System(with_numbers(base, {name: own[name] + n * h}))
            run = sr.simulate(other, start, until=until, store="steps", **TIGHT)
            found.append(sr.sensitivity(run, response, names).matrix[0])
        rows.append((found[0] - 8 * found[1] + 8 * found[2] - found[3]) / (12 * h))
    return np.array(rows)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("start", [SETTLED, DRIVEN])
def test_hessians_go_through_the_equilibrium(start: dict[str, Any]) -> None:
    names, response = ["spring.k", "rod.mass", "pin.point.z"], sr.Final("slider.x")
    run = sr.simulate(sr.System(BASE), start, until=0.3, store="steps", **TIGHT)
    found = sr.hessian(run, response, names).matrix
    wanted = bends(BASE, start, 0.3, response, names)
    assert found == pytest.approx(wanted, rel=1e-5, abs=1e-7 * abs(wanted).max())
    assert abs(found).max() > 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("law", ["40 + 30*x**2", [[-3, 60], [-1, 45], [0, 40], [1, 50], [3, 70]]])
def test_hessians_with_laws_and_forces_without_a_potential(law: Any) -> None:
    system, start = hanging(law), {"equilibrium": True, "rates": {"pin": 1.0}}
    names = ["rod.mass", "jet.force.z"]
    names += [name for name in written_numbers(system.model) if name.startswith("coil.k")][1:3]
    run = sr.simulate(system, start, until=0.4, store="steps", **TIGHT)
    response = sr.Final("rod.x")
    found = sr.hessian(run, response, names).matrix
    wanted = bends(system.model, start, 0.4, response, names)
    assert found == pytest.approx(wanted, rel=1e-5, abs=1e-7 * abs(wanted).max())
    assert np.all(abs(found).max(axis=1) > 0)


@pytest.mark.slow
@pytest.mark.parametrize(
    "make", [rest, lambda: SETTLED, lambda: lambda system: sr.equilibrium(system, rest().q)]
)
def test_searches_settle_every_design(make: Callable[[], Any]) -> None:
    """The stiffness that belongs to the end of a motion, which only depends on the equilibrium."""
    start = make()
    system, wanted = sr.System(BASE), end(None, {"spring.k": 14.0})
    problem = sr.Problem(system, sr.Final("slider.x"), ["spring.k"], until=0.3, start=start, **TIGHT)
    assert problem.values(np.array([14.0]))[0] == pytest.approx(wanted, abs=1e-9)
    by_k = slope(lambda k: end(None, {"spring.k": k}), 14.0, 14.0)
    assert problem.gradient(np.array([14.0])).matrix[0, 0] == pytest.approx(by_k, rel=1e-6)
    misfit = sr.Misfit("slider.x", at=(0.1, 0.3), data=(wanted, wanted), sigma=1e-4)
    assert sr.fit(system, misfit, ["spring.k"], start=start).x == pytest.approx([14.0], rel=1e-5)
    goal = sr.Combined(lambda x: (x - wanted) ** 2, [sr.Final("slider.x")])
    bounds = {"spring.k": (8, 20)}
    found = sr.optimize(system, goal, ["spring.k"], until=0.3, start=start, bounds=bounds)
    assert found.x == pytest.approx([14.0], rel=1e-3)


def test_studies_and_uncertainty_settle_every_case() -> None:
    run = Simulation(0.3, steps=10, start=SETTLED, **TIGHT)
    table = study(BASE, {"spring.k": [9.9, 10.1]}, "slider.x", analysis=run, workers=1)
    assert table.found[:, 0] == pytest.approx([end(None, {"spring.k": k}) for k in (9.9, 10.1)], abs=1e-9)
    found = uncertainty(BASE, {"spring.k": Range(9.9, 10.1)}, "slider.x", analysis=run)
    assert found.matrix[0, 0] == pytest.approx((table.found[1, 0] - table.found[0, 0]) / 0.2, rel=1e-3)
    by_function = Simulation(0.3, steps=10, start=lambda system: sr.equilibrium(system, rest().q), **TIGHT)
    again = study(BASE, {"spring.k": [9.9, 10.1]}, "slider.x", analysis=by_function, workers=1)
    assert again.found == pytest.approx(table.found, abs=1e-9)


def test_files_settle_first(tmp_path: Path) -> None:
    BASE.save(tmp_path / "crank.yaml")
    analysis = "analysis: {type: simulate, until: 0.3, steps: 10, start: {equilibrium: true, rates: {pin: 2 rad/s}}}\n"
    (tmp_path / "study.yaml").write_text(
        f"model: crank.yaml\nparameters: {{spring.k: [9, 11]}}\nresponses: {{x: slider.x}}\n{analysis}"
    )
    from sarrus.studies.conduct import carry_out

    table = carry_out(read_study_file(tmp_path / "study.yaml", sr.load), workers=1)
    assert table["x"] == pytest.approx([end(2.0, {"spring.k": k}) for k in (9.0, 11.0)], abs=1e-6)
    (tmp_path / "best.yaml").write_text(
        f"model: crank.yaml\nparameters: {{spring.k: {{from: 8, to: 12}}}}\nminimize: final(slider.x)\n{analysis}"
    )
    best = read_optimization_file(tmp_path / "best.yaml", sr.load).solved()
    assert best.success
    assert best.value == pytest.approx(min(end(2.0, {"spring.k": k}) for k in (8.0, 12.0)), abs=1e-6)


def test_what_has_no_derivative_is_refused() -> None:
    system = sr.System(BASE)

    def faster(system: sr.System) -> sr.Assembly:
        return sr.assemble(system, rates={"pin": system.model.forces[0].k / 5})

    with pytest.raises(sr.ModelError, match="start: the function returns rates that depend"):
        sr.Problem(system, sr.Final("slider.x"), ["spring.k"], until=0.1, start=faster)
    table = study(
        BASE,
        {"spring.k": [5, 10]},
        "crank.angular_velocity.x",
        analysis=Simulation(1e-9, start=faster, steps=1),
        workers=1,
    )
    assert table.found[:, 0] == pytest.approx([1, 2], rel=1e-6)

    def gone_on(system: sr.System) -> Any:
        return sr.simulate(system, until=0.1).final

    with pytest.raises(sr.ModelError, match="start: the function returns a state that depends"):
        sr.Problem(system, sr.Final("slider.x"), ["spring.k"], until=0.2, start=gone_on)
    with pytest.raises(sr.ModelError, match="equilibrium must be true or false"):
        sr.simulate(system, {"equilibrium": "soon"}, until=0.1)
    free = sr.System(sr.Model("free", [sr.Body("ball", 1, (1, 1, 1))]))
    run = sr.simulate(free, SETTLED, until=0.1, store="steps")
    with pytest.raises(ArithmeticError, match="free: a motion has no stiffness"):
        sr.sensitivity(run, sr.Final("ball.x"), ["ball.mass"])


@pytest.mark.slow
def test_a_case_without_an_equilibrium_is_a_row_with_its_reason() -> None:
    falling = sr.System(sr.Model("falling", [sr.Body("ball", 1, (1, 1, 1))], gravity=(0, 0, -9.81)))
    run = sr.simulate(falling, SETTLED, until=0.1)
    assert not run.success
    assert "no equilibrium" in run.message
    table = study(
        falling, {"ball.mass": [1, 2]}, "ball.z", analysis=Simulation(0.1, start=SETTLED), workers=1
    )
    assert not table.success.any()
    assert all("no equilibrium" in message for message in table.failures.values())
    statics = study(falling, {"ball.mass": [1]}, "ball.z", analysis=Statics(), workers=1)
    assert "no equilibrium" in str(statics.failures)
