"""A model's construction in sparse matrices is differentiated as entry by entry, and stops where there is no slope."""

import importlib

import numpy as np
import pytest
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.sensitivity.parameters.linearized import TapeDerivatives
from sarrus.model.tape import Tape


def recorded() -> tuple[Tape, list[int], list[tuple[int, int]]]:
    """Some numbers, what follows from them by every operation, and some of that as results."""
    tape, random = Tape(), np.random.default_rng(0)
    given = [tape.variable(x) for x in random.uniform(0.2, 0.9, 6)]
    a, b, c, d, e, f = given
    found = [
        a * b - c / d,
        np.sqrt(a * a + e),
        np.arctan2(b, c) ** 3,
        -abs(d - e) + np.exp(f * a),
        np.log(b) + 2.0,
    ]
    found += [
        np.sin(found[0]) * np.cos(f),
        np.tan(a) + np.tanh(c),
        np.arcsin(d) * np.arccos(e),
        np.arctan(found[1]),
    ]
    return tape, [x.at for x in given], [(n % 7, x.at) for n, x in enumerate(found)]


def test_as_entry_by_entry() -> None:
    tape, variables, outputs = recorded()
    whole, random = TapeDerivatives(tape, variables, outputs, 7), np.random.default_rng(1)
    change, weights, turned = random.normal(size=(6, 2)), random.normal(size=7), random.normal(size=7)
    for k in range(2):
        dots = tape.along(dict(zip(variables, change[:, k], strict=True)))
        wanted = np.zeros(7)
        for place, at in outputs:
            wanted[place] += dots[at]
        assert np.allclose(whole.along(change)[:, k], wanted, rtol=1e-13)
    bars: dict[int, float] = {}
    bar_dots: dict[int, float] = {}
    for place, at in outputs:
        bars[at] = bars.get(at, 0.0) + weights[place]
        bar_dots[at] = bar_dots.get(at, 0.0) + turned[place]
    first, second = tape.gradient_along(bars, bar_dots, dots)
    assert np.allclose(whole.gradient(weights), [first[at] for at in variables], rtol=1e-13)
    assert np.allclose(
        whole.gradient_along(weights, turned, change[:, 1]), [second[at] for at in variables], rtol=1e-12
    )


def test_nothing_passes_where_there_is_no_slope() -> None:
    """The root of x² at 0 has none; what does not depend on it, or does not move it, does."""
    tape = Tape()
    x, y = tape.variable(0.0), tape.variable(2.0)
    outputs = [(0, np.sqrt(x).at), (1, (y * y).at)]
    found = TapeDerivatives(tape, [x.at, y.at], outputs, 2)
    assert np.array_equal(found.along(np.array([0.0, 1.0])), [0.0, 4.0])
    assert np.isnan(found.along(np.array([1.0, 0.0]))).all()
    assert np.array_equal(found.gradient(np.array([0.0, 1.0])), [0.0, 4.0])
    assert np.isnan(found.gradient(np.array([1.0, 0.0]))).all()


def test_the_way_through_the_construction_is_made_once(monkeypatch: pytest.MonkeyPatch) -> None:
    parameters = importlib.import_module("sarrus.analyses.sensitivity.parameters.parameters")
    made: list[int] = []
    kind = parameters.TapeDerivatives
    monkeypatch.setattr(parameters, "TapeDerivatives", lambda *given: made.append(1) or kind(*given))
    system = sr.System(slider_crank().model)
    names = ["spring.k", "rod.mass"]
    for until in (0.05, 0.1):
        run = sr.simulate(system, until=until, store="steps")
        sr.hessian(run, "slider.x", names)
        sr.sensitivity(run, "slider.x", names, method="direct")
    assert len(made) == 1
    sr.sensitivity(run, "slider.x", ["spring.k"])
    assert len(made) == 2


def test_a_design_is_recorded_each_time() -> None:
    """A formula may compute something else the next time."""
    run = sr.simulate(slider_crank(), until=0.05, store="steps")
    given: dict[str, float] = {}
    found = []
    for power in (1.0, 2.0):
        given["power"] = power
        formula = lambda p: {"spring.k": 10.0 * p["stiff"] ** given["power"]}  # noqa: E731
        found.append(sr.sensitivity(run, "slider.x", design={"stiff": 1.0}, formula=formula)["stiff"])
    assert found[1] == pytest.approx(2 * found[0])


def test_second_derivatives_by_an_orientation() -> None:
    """Euler parameters of a guess are brought to unit length: e0 = 1 / sqrt(1 + e2²)."""
    body = sr.Body("body", mass=1.0, inertia=(1.0, 1.0, 1.0))
    run = sr.simulate(sr.System(sr.Model("still", bodies=[body])), until=0.1, store="steps")
    found = sr.hessian(run, "body.e0", ["body.orientation.e2", "body.orientation.e3"])
    assert np.allclose(found.matrix, -np.eye(2), atol=1e-12)
