"""Designs and fitted parameters: a published optimum, constraints, measurements with noise, what data cannot tell."""

import json
import logging
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.patience import within_by_the_clock
from tests.sensitivity.designs import sundials_crank
from tests.sensitivity.test_references import FOLDER
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.optimization.point import DesignError, Point
from sarrus.analyses.optimization.search import Search, Variables
from sarrus.analyses.sensitivity.combined import Composite
from sarrus.model.written import with_numbers

LOOSE = {"method": sr.Radau(rtol=1e-5, atol=1e-7)}


def penalized(o: object) -> object:
    k, c = o.parameter("spring.k"), o.parameter("spring.c")
    return o("energy.kinetic") + 0.05 * ((k - 1) ** 2 + (c - 1) ** 2)  # over 10 s


@pytest.mark.one_in(2)
@pytest.mark.parametrize("solver", ["L-BFGS-B", "trust-constr"])
def test_the_optimum_of_the_published_slider_crank(solver: str) -> None:
    """Its minimum is k = 0.6826136, c = 1.3357019, 3.2227612; the method's error moves it a little."""
    found = sr.optimize(
        sundials_crank(), sr.Integral(penalized), ["spring.k", "spring.c"], until=10.0, solver=solver, **LOOSE
    )
    assert found.x == pytest.approx([0.6826136, 1.3357019], abs=5e-3)
    assert found.value == pytest.approx(3.2227612, abs=5e-3)
    assert found.value < found.value0
    assert len(found.history) == len(found.trace) < 30
    assert np.nanmin(found.history[:, 1]) < 1e-2 * found.history[0, 1]
    assert found.model.forces[0].k == pytest.approx(found["spring.k"])
    assert "spring.k" in str(found)


@pytest.mark.slow
def test_the_optimum_in_many_digits() -> None:
    """Runs of Radau scatter so little from design to design that solvers see them as smooth."""
    told, errors = json.loads((FOLDER / "S12_slider_crank_optimum.json").read_text()), []
    for tolerance in (1e-5, 1e-7):
        settings = {"method": sr.Radau(rtol=tolerance, atol=1e-2 * tolerance), "tolerance": 1e-12}
        cost, names = sr.Integral(penalized), ["spring.k", "spring.c"]
        found = sr.optimize(sundials_crank(), cost, names, until=10.0, **settings)
        assert found.success
        assert len(found.history) < 25  # the last ones are within round-off, and differ between processors
        errors.append(abs(found.x - [*told["x_opt"].values()]).max())
    assert found.value == pytest.approx(told["psi"], abs=3e-7)
    assert errors[0] > 8 * errors[1], errors
    assert errors[1] < 4e-7, errors  # of runs with these tolerances


def test_constraints_and_bounds_hold() -> None:
    limit = sr.Within(sr.Final("slider.velocity.x", name="last"), upper=-1.0)
    bounds = {"spring.k": (5.0, 40.0), "spring.c": (0.5, 5.0)}
    effort = sr.Integral(lambda o: o("slider.velocity.x") ** 2)
    found = sr.optimize(
        slider_crank(), effort, [*bounds], until=1.0, bounds=bounds, constraints=[limit], **LOOSE
    )
    assert found.constraints["last"] == pytest.approx(-1.0, abs=1e-5)
    assert found.value < found.value0 - 0.05
    for name, (low, high) in bounds.items():
        assert low - 1e-9 <= found[name] <= high + 1e-9


NAMES = ["spring.k", "spring.c", "rod.mass"]
TIMES = np.linspace(0.05, 1.5, 30)


def measured(noise: float) -> sr.Misfit:
    """The slider's path with the model's own numbers, and noise."""
    run = sr.simulate(slider_crank(), until=1.5, t_eval=TIMES, method=sr.Radau(rtol=1e-7, atol=1e-9))
    data = run["slider"].position[:, 0] + noise * np.random.default_rng(0).normal(size=len(TIMES))
    return sr.Misfit("slider.x", at=tuple(TIMES), data=tuple(data), sigma=noise)


def guessed(**numbers: float) -> sr.System:
    wrong = {"spring.k": 14.0, "spring.c": 0.6, "rod.mass": 1.3} | numbers
    return sr.System(with_numbers(slider_crank().model, wrong))


def test_parameters_are_recovered_from_measurements_with_noise() -> None:
    found = sr.fit(guessed(), measured(1e-3), NAMES, **LOOSE)
    assert found.success
    assert 5 < found.value < 30  # half of the sum of 30 squares less 3
    assert not found.poor
    for name, true in zip(NAMES, (10.0, 1.0, 1.0), strict=True):
        low, high = found.interval(name)
        width = high - low
        assert low - width < true < high + width
        assert 0 < width < true
    assert "95 % interval" in str(found)


def test_a_fit_needs_little_more_than_a_simulation_and_a_gradient_per_iteration(monkeypatch: Any) -> None:
    """The Jacobian of a design is computed once, and tells the distance from the optimum without other designs."""
    counts = {"_simulate": 0, "_with_derivatives": 0}

    def counting(name: str) -> Any:
        made = getattr(Point, name)

        def counted(self: Point, *given: Any) -> Any:
            counts[name] += 1
            return made(self, *given)

        return counted

    for name in counts:
        monkeypatch.setattr(Point, name, counting(name))
    found = sr.fit(guessed(), measured(1e-3), NAMES, **LOOSE)
    lower = int(np.sum(np.diff(np.minimum.accumulate(found.history[:, 0])) < 0))
    assert found.success
    assert counts["_simulate"] <= 1.5 * lower + 1  # the last one has the default output times
    assert counts["_with_derivatives"] <= 1.5 * lower


def test_signs_that_the_model_needs_are_limits_of_a_search() -> None:
    """Without them, half of the designs from here had a negative damping, and could not be built."""
    found = sr.fit(guessed(**{"spring.k": 100.0, "spring.c": 10.0}), measured(1e-3), NAMES[:2], **LOOSE)
    assert not found.failures
    assert "used up" not in found.message
    assert found["spring.c"] >= 0


def test_designs_beyond_one_that_failed_are_not_simulated() -> None:
    """The best mass is zero: every line search leads beyond it, and steps back without simulations."""

    def formula(d: Any) -> Any:
        return {"spring.k": 10 + 0 * d["x"], "rod.mass": 3.0 - d["x"] - d["y"]}

    goal = sr.Final(
        lambda o: -1 * o.parameter("x") - 1e-3 * o.parameter("y") + 0 * o("slider.x"), name="goal"
    )
    found = sr.optimize(
        slider_crank(), goal, design={"x": 1.0, "y": 1.0}, formula=formula, until=0.01, solver="SLSQP",
        bounds={"x": (-1e6, 1e6), "y": (0.9, 1.1)}, iterations=20,
    )  # fmt: skip
    assert found["x"] == pytest.approx(2.0, abs=0.01)
    assert len(found.failures) <= 10


def test_one_well_determined_parameter_beside_a_better_one_is_determined() -> None:
    """The interval counts, not the ratio to that of the best combination."""
    times = tuple(np.linspace(0.05, 1.5, 30))
    body = sr.Body("mass", mass=1.0, inertia=(1, 1, 1), position=(0, 0, 0), velocity=(1.0, 0, 0))
    push = sr.PointForce("push", body.point(0, 0, 0), force=(3.0, 1e-4, 0))
    system = sr.System(sr.Model("mass", bodies=[body], forces=[push]))
    data = [
        sr.Misfit(
            f"mass.{axis}", at=times, data=tuple(f * np.square(times) / 2 + v * np.array(times)), sigma=s
        )
        for axis, f, v, s in (("x", 3.0, 1.0, 1e-6), ("y", 1e-4, 0.0, 1e-6))
    ]
    found = sr.fit(system, data, ["push.force.x", "push.force.y"], **LOOSE)
    low, high = found.interval("push.force.y")
    assert high - low < 0.05 * found["push.force.y"]
    assert not found.poor


def test_a_design_without_derivatives_ends_the_search_with_its_message() -> None:
    """A mass with a root at the bound: the best design is kept."""
    ball = sr.Body("ball", mass=1.0, inertia=(1.0, 1.0, 1.0))
    push = sr.PointForce("push", ball.point(0, 0, 0), force=(0, 0, 2.0))
    system = sr.System(sr.Model("pushed", bodies=[ball], forces=[push]))
    found = sr.optimize(
        system, sr.Final(lambda o: -1 * o("ball.z")), until=0.1, design={"d": 1.0},
        formula=lambda p: {"ball.mass": 0.5 * np.sqrt(p["d"]) + 0.5},
    )  # fmt: skip
    assert not found.success
    assert "no derivative by d at this design" in found.message
    assert found.value < found.value0


def test_what_the_data_cannot_tell_is_named() -> None:
    """Stiffness and actuator of a spring whose length hardly changes."""
    body = sr.Body("mass", mass=1.0, inertia=(1, 1, 1), position=(1.0, 0, 0), velocity=(1.0, 0, 0))
    spring = sr.TSDA("spring", sr.ground.point(0, 0, 0), body.point(0, 0, 0), k=2.0, length=0.5, force=0.3)
    system = sr.System(sr.Model("mass", bodies=[body], forces=[spring]))
    times = np.linspace(0.1, 1.0, 10)
    data = 1 + times - 0.6 * times**2
    misfit = sr.Misfit("mass.x", at=tuple(times), data=tuple(data), sigma=1e-3)
    found = sr.fit(system, misfit, ["spring.length", "spring.force"], **LOOSE)
    assert len(found.poor) == 1
    assert "spring.length" in found.poor[0]
    assert "hardly determined" in str(found)


@pytest.mark.slow
def test_a_parameter_that_the_data_do_not_feel_leaves_the_others_alone() -> None:
    """Its column of the Jacobian is the rounding of nothing, by which deviations of the others were multiplied."""
    options = {"until": 1.5, **LOOSE}
    alone = sr.fit(guessed(), measured(1e-3), ["spring.k"], **options)
    both = sr.fit(guessed(), measured(1e-3), ["spring.k", "crank.inertia.yy"], **options)
    assert both["crank.inertia.yy"] == pytest.approx(1.0, rel=1e-9)
    assert both.deviations[0] == pytest.approx(alone.deviations[0], rel=1e-3)
    assert "crank.inertia.yy" in both.poor[0]
    assert "not determined" in str(both)


def test_a_parameter_that_is_found_to_be_zero_is_determined() -> None:
    """Its deviation is infinitely many times its value, and as small as that of others."""
    found = sr.fit(guessed(), measured(1e-3), ["spring.k", "spring.force"], until=1.5, **LOOSE)
    exact = replace(found, x=np.array([found.x[0], 1e-14]))
    assert "not determined" not in str(exact)


def test_bounds_of_unknown_variables_are_refused() -> None:
    with pytest.raises(ValueError, match="no design variable"):
        sr.optimize(slider_crank(), "slider.x", ["spring.k"], until=0.1, bounds={"spring.c": (0, 1)})


def test_bounds_and_scales_have_names_as_wrt() -> None:
    """A vector or a part is all of its variables; a full name has priority over it."""
    names, x0 = ("pin.point.x", "pin.point.y", "kp.value"), np.array([0.5, 0.5, 20.0])
    limits = {"pin.point.y": (None, 2), "pin.point": (0, 1), "kp": (1, 80)}
    found = Variables(names, x0, limits, {"kp": 7, "pin": 3})
    np.testing.assert_array_equal(found.limits, [[0, 1], [-np.inf, 2], [1, 80]])
    np.testing.assert_array_equal(found.scale, [3, 3, 7])
    for what in ("bounds", "scale"):
        with pytest.raises(ValueError, match=f"{what}: 'k' is no design variable. Choose from"):
            Variables(names, x0, **{"bounds": None, "scale": None, what: {"k": (1, 2)}})


def problem() -> sr.Problem:
    wanted = [sr.Final("slider.x"), sr.Integral("energy.kinetic"), sr.At("pin.angle", time=0.2)]
    return sr.Problem(slider_crank(), wanted, ["spring.k", "rod.mass", "pin.point.y"], until=0.4, **LOOSE)


def test_products_with_vectors_are_those_of_the_gradient() -> None:
    p = problem()
    x = p.x0 + [0.5, 0.1, 0.01]
    matrix = p.gradient(x).matrix
    change, weights = np.array([0.3, -1.0, 2.0]), np.array([1.0, -0.5, 0.2])
    assert np.allclose(p.jvp(x, change), matrix @ change, rtol=1e-9, atol=0)
    assert np.allclose(p.vjp(x, weights), weights @ matrix, rtol=1e-9, atol=0)
    value, slope = p.value_and_grad(x)
    assert value == p.values(x)[0] == p.gradient(x).values[0]
    assert np.array_equal(slope, matrix[0])


def test_another_number_of_values_is_refused() -> None:
    with pytest.raises(ValueError, match="3 values are expected"):
        problem().values(np.ones(2))


def forked(reach: float = 1.2) -> sr.System:
    """A pendulum on a rod of a length that cannot be closed when its post stands too far away."""
    swing = sr.Body("swing", mass=1.0, inertia=(1, 1, 1), position=(1.0, 0, 0))
    joints = [
        sr.Revolute("pin", sr.ground, swing, point=(0, 0, 0), axis=(0, 0, 1)),
        sr.Distance("rod", sr.ground.point(reach, 1.0, 0), swing.point(0, 0, 0), length=1.0),
    ]
    return sr.System(sr.Model("fork", [swing], joints))


def far(o: object) -> object:
    return (o.parameter("rod.point_i.x") - 1.5) ** 2 + 0 * o("swing.x")


@pytest.mark.one_in(4)
@pytest.mark.filterwarnings("ignore:fork. (nothing can move|assembly changed)")
@pytest.mark.parametrize("solver", ["L-BFGS-B", "SLSQP", "trust-constr"])
def test_designs_that_cannot_be_assembled_make_a_solver_step_back(solver: str) -> None:
    """The best post is where it may stand; the first long step leads to where no rod reaches it."""
    found = sr.optimize(
        forked(), sr.Final(far), ["rod.point_i.x"], until=0.01, solver=solver, scale={"rod.point_i.x": 30.0}
    )
    assert found.failures
    assert "failed" in found.message
    assert found["rod.point_i.x"] == pytest.approx(1.5, abs=1e-3)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:fork. (nothing can move|assembly changed)")
def test_a_search_with_nothing_ahead_gives_up_with_the_sentence() -> None:
    goal = sr.Final(lambda o: -o.parameter("rod.point_i.x") + 0 * o("swing.x"))
    found = sr.optimize(forked(1.7), goal, ["rod.point_i.x"], until=0.01, iterations=200)
    assert 1.7 < found["rod.point_i.x"] < 1.7321  # the root of 3 is the end
    assert found.failures


def test_a_first_design_that_cannot_be_simulated_is_an_error() -> None:
    with pytest.raises(sr.SarrusError):
        sr.optimize(forked(3.0), sr.Final(far), ["rod.point_i.x"], until=0.01)


def waves(o: object) -> object:
    """Many valleys in the stiffness, the deepest at 12."""
    k = o.parameter("spring.k")
    return 1 - np.cos(2 * (k - 12)) + 0.02 * (k - 12) ** 2 + 0 * o("slider.x")


@pytest.mark.slow
def test_several_starts_find_the_deepest_valley() -> None:
    settings = {"until": 0.02, "bounds": {"spring.k": (1.0, 30.0)}, **LOOSE}
    one = sr.optimize(slider_crank(), sr.Final(waves), ["spring.k"], **settings)
    many = sr.optimize(slider_crank(), sr.Final(waves), ["spring.k"], starts=12, **settings)
    assert many["spring.k"] == pytest.approx(12.0, abs=1e-3)
    assert len(many.starts) == 12
    assert many.starts[0].value == many.value <= one.value
    assert many.starts[-1].value > 0.1
    assert "of 12 starts came to it" in many.message


@pytest.mark.slow
def test_starts_run_in_an_executor() -> None:
    from concurrent.futures import ThreadPoolExecutor

    settings = {"until": 0.02, "bounds": {"spring.k": (1.0, 30.0)}, "starts": 3, "seed": 1, **LOOSE}
    here = sr.optimize(slider_crank(), sr.Final(waves), ["spring.k"], **settings)
    with ThreadPoolExecutor(1) as executor:
        there = sr.optimize(slider_crank(), sr.Final(waves), ["spring.k"], executor=executor, **settings)
    assert [one.value for one in there.starts] == [one.value for one in here.starts]


@pytest.mark.slow
def test_the_time_of_all_starts_is_over_in_an_executor_too() -> None:
    """Starts that are still queued when it is over are not simulated."""
    from concurrent.futures import ThreadPoolExecutor

    settings = {"until": 0.02, "bounds": {"spring.k": (1.0, 30.0)}, "starts": 100, **LOOSE}
    with within_by_the_clock(60), ThreadPoolExecutor(1) as executor:
        found = sr.optimize(
            slider_crank(), sr.Final(waves), ["spring.k"], executor=executor, total_time_limit=3.0, **settings
        )
    late = [one for one in found.start_reports if "the time limit of 3 s has passed" in one.message]
    assert len(late) > 20


def test_a_start_without_derivatives_ends_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """As where the time is over in the middle of its gradient: the wall around it was asked for its slope, for ever."""

    def undefined(point: Point) -> None:
        raise DesignError("it has no derivatives")

    monkeypatch.setattr(Point, "slopes", property(undefined))
    with pytest.raises(sr.SarrusError, match="it has no derivatives"):
        sr.optimize(
            slider_crank(), "slider.x", ["spring.k"], until=0.02, bounds={"spring.k": (1.0, 30.0)}, **LOOSE
        )


@pytest.mark.one_in(2)
@pytest.mark.parametrize("solver", ["SLSQP", "trust-constr"])
def test_a_constraint_that_cannot_hold_is_told(solver: str) -> None:
    """Where the slider starts no spring can help."""
    far = sr.Within(sr.Maximum("slider.x", name="far"), upper=4.0)
    settings = {
        "until": 0.02,
        "bounds": {"spring.k": (5.0, 20.0)},
        "solver": solver,
        "iterations": 5,
        **LOOSE,
    }
    stiffness = sr.Final(lambda o: o.parameter("spring.k") + 0 * o.t)
    found = sr.optimize(slider_crank(), stiffness, ["spring.k"], constraints=[far], **settings)
    assert not found.success
    assert "a constraint is short of its limit by" in found.message


def test_several_starts_need_bounds() -> None:
    with pytest.raises(ValueError, match="need both bounds"):
        sr.optimize(slider_crank(), "slider.x", ["spring.k"], until=0.1, starts=2)


def test_an_equation_holds_and_both_solvers_agree() -> None:
    kept = sr.Within(sr.Final("slider.x", name="place"), lower=4.45, upper=4.45)
    cost = sr.Final(
        lambda o: (o.parameter("spring.c") - 1) ** 2 + (o.parameter("spring.k") / 10 - 1) ** 2 + 0 * o.t
    )
    found = [
        sr.optimize(
            slider_crank(),
            cost,
            ["spring.k", "spring.c"],
            until=0.5,
            constraints=[kept],
            solver=solver,
            **LOOSE,
        )
        for solver in ("SLSQP", "trust-constr")
    ]
    assert [one.constraints["place"] for one in found] == pytest.approx([4.45, 4.45], abs=1e-5)
    assert found[0].x == pytest.approx(found[1].x, rel=1e-2)


@pytest.mark.slow
def test_noise_is_estimated_from_what_remains() -> None:
    """Ten times the sigma changes nothing when only its ratios count."""
    data = measured(1e-3)
    wide = sr.Misfit("slider.x", at=data.at, data=data.data, sigma=1e-2)
    one, other = (sr.fit(guessed(), m, NAMES, noise="estimated", **LOOSE) for m in (data, wide))
    assert one.deviations == pytest.approx(other.deviations, rel=1e-3)
    assert one.spare == 27
    assert one.quantile == pytest.approx(2.0518, abs=1e-4)  # Student's, 27 degrees of freedom


@pytest.mark.slow
def test_residuals_that_noise_does_not_explain_are_told() -> None:
    """A tenth of the sigma that is true; where only ratios of sigma count there is nothing to say."""
    data = measured(1e-3)
    small = sr.Misfit("slider.x", at=data.at, data=data.data, sigma=1e-4)
    given, estimated = (
        sr.fit(guessed(), small, NAMES, noise=noise, **LOOSE) for noise in ("given", "estimated")
    )
    assert "times as large as sigma" in given.message
    assert "sigma" not in estimated.message
    assert "sigma" not in sr.fit(guessed(), data, NAMES, **LOOSE).message


def test_too_few_measurements_are_refused() -> None:
    with pytest.raises(ValueError, match="2 measured numbers cannot determine 3 parameters"):
        sr.fit(guessed(), sr.Misfit("slider.x", at=(0.1, 0.2), data=(4.0, 4.0)), NAMES)


def test_a_simulation_that_takes_too_long_is_given_up() -> None:
    with pytest.raises(sr.SarrusError, match=r"when its .* s were over"):
        sr.optimize(slider_crank(), "slider.x", ["spring.k"], until=0.5, time_limit=1e-6, **LOOSE)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"solver": "Newton"}, "there is no solver 'Newton'"),
        (
            {"solver": "L-BFGS-B", "constraints": [sr.Within("slider.x", upper=1)]},
            "does not support constraints",
        ),
        ({"bounds": {"spring.k": (3, 2)}}, "must rise, but are 3 and 2. Exchange them"),
        ({"bounds": {"spring.k": (3, 3)}}, "must rise, but are 3 and 3. Leave it out"),
        ({"scale": {"spring.k": 0.0}}, "must be a positive number"),
        ({"starts": 0}, "1 at least"),
        ({"tolerance": -1.0}, "tolerance must be a positive number"),
        ({"iterations": 0}, "iterations must be 1 at least"),
        ({"bounds": {"spring.k": 3.0}}, r"the bounds of spring\.k are two numbers"),
        ({"bounds": {"spring.k": (1, 2, 3)}}, r"the bounds of spring\.k are two numbers"),
        ({"second_order": True}, "L-BFGS-B does not use second derivatives. Choose trust-constr or IPOPT"),
    ],
)
def test_misuse_is_one_sentence(options: dict[str, object], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        sr.optimize(slider_crank(), "slider.x", ["spring.k"], until=0.1, **options)


def test_something_else_than_a_constraint_is_refused() -> None:
    with pytest.raises(TypeError, match="is no constraint"):
        sr.optimize(slider_crank(), "slider.x", ["spring.k"], until=0.1, constraints=[sr.Final("slider.x")])


def test_one_constraint_and_lines_of_progress(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(logging.getLogger("sarrus"), "handlers", [])  # commands show the log there, too
    limit, options = sr.Within("slider.x", upper=10.0), {"until": 0.1, "iterations": 2, **LOOSE}
    found = sr.optimize(slider_crank(), "slider.x", ["spring.k"], constraints=limit, progress=True, **options)
    assert list(found.constraints) == ["final of slider.x 2"]  # the objective has this name, too
    told = [line for line in capsys.readouterr().err.splitlines() if line.startswith("simulation")]
    assert len(told) == len(found.history)  # other lines: designs that cannot be simulated
    assert told[0].startswith("simulation 1: objective 4.")


def test_a_constraint_without_limits_is_refused() -> None:
    with pytest.raises(ValueError, match="a lower or an upper limit"):
        sr.Within("slider.x")


def test_convergence_is_drawn() -> None:
    found = sr.optimize(slider_crank(), "slider.x", ["spring.k"], until=0.1, iterations=3, **LOOSE)
    axes = found.plot()
    assert axes.get_xlabel() == "simulation"
    assert len(axes.figure.axes) == 2


def test_responses_of_responses() -> None:
    """A quotient of two integrals and a maximum, beside them."""
    parts = [sr.Integral("energy.kinetic"), sr.Maximum("spring.length"), sr.Minimum("spring.length")]
    mixed = sr.Combined(lambda e, top, low: np.sqrt(e) / (top - low), parts, name="mixed")
    p = sr.Problem(slider_crank(), [mixed, *parts], ["spring.k", "rod.mass"], until=0.4, **LOOSE)
    found = p.gradient(p.x0)
    e, top, low = found.values[1:]
    assert found.responses[0] == "mixed"
    assert found.values[0] == pytest.approx(np.sqrt(e) / (top - low))
    by_e, by_range = 0.5 / np.sqrt(e) / (top - low), -np.sqrt(e) / (top - low) ** 2
    assert np.allclose(
        found.matrix[0], by_e * found.matrix[1] + by_range * (found.matrix[2] - found.matrix[3])
    )
    assert np.allclose(p.vjp(p.x0, np.array([1.0, 0, 2.0, 0])), found.matrix[0] + 2 * found.matrix[2])
    assert np.allclose(p.jvp(p.x0, np.array([1.0, -2.0])), found.matrix @ [1.0, -2.0])


def test_hessian_products_are_differences_of_gradients() -> None:
    wanted = sr.Integral(lambda o: o("energy.kinetic") * o.parameter("spring.k") ** 2, name="weighed")
    p = sr.Problem(
        slider_crank(), wanted, ["spring.k", "rod.mass"], until=0.3, method=sr.Radau(rtol=1e-7, atol=1e-9)
    )
    direction, e = np.array([1.0, -0.1]), 1e-3
    ends = [p.gradient(p.x0 + d * direction).matrix[0] for d in (e, -e)]
    assert np.allclose(p.hvp(p.x0, direction), (ends[0] - ends[1]) / (2 * e), rtol=1e-4)


@pytest.mark.slow
def test_exact_hessians_lead_to_the_same_optimum() -> None:
    found = sr.optimize(
        sundials_crank(), sr.Integral(penalized), ["spring.k", "spring.c"], until=10.0, solver="trust-constr",
        second_order=True, **LOOSE,
    )  # fmt: skip
    assert found.x == pytest.approx([0.6826136, 1.3357019], abs=5e-3)
    assert len(found.history) < 12


def test_the_hessian_of_objective_and_constraints_is_that_of_differenced_gradients() -> None:
    """As solvers get it: of scaled variables, weighted, with two objectives and two constraints."""
    wanted = [
        sr.Integral("energy.kinetic"),
        sr.Final("slider.x"),
        sr.Final("pin.angle"),
        sr.Integral("slider.x"),
    ]
    settings = {"until": 0.3, "method": sr.HHT(step=1e-2)}
    p = sr.Problem(slider_crank(), wanted, ["spring.k", "rod.mass", "pin.point.y"], **settings)
    limits = tuple(sr.Within(one, upper=1.0) for one in wanted[2:])
    search = Search(p, Variables(p.names, p.x0, None, {"spring.k": 3.0}), limits)
    z, weights = search.variables.z0, np.array([0.7, -2.0])
    found, e = search.curvature(z, 1.5, weights), 1e-3

    def slope(at: np.ndarray) -> np.ndarray:
        return 1.5 * search.slope(at) + weights @ search.other_slopes(at)

    columns = [(slope(z + e * d) - slope(z - e * d)) / (2 * e) for d in np.eye(3)]
    assert np.allclose(found, columns, rtol=0, atol=1e-4 * abs(found).max())
    assert np.array_equal(found, found.T)


@pytest.mark.slow
def test_exact_hessians_of_constraints_take_fewer_simulations() -> None:
    limit = sr.Within(sr.Final("slider.velocity.x", name="last"), upper=-1.0)
    bounds = {"spring.k": (5.0, 40.0), "spring.c": (0.5, 5.0)}
    effort, settings = sr.Integral(lambda o: o("slider.velocity.x") ** 2), {"method": sr.HHT(step=0.02)}
    learnt, exact = (
        sr.optimize(
            slider_crank(), effort, [*bounds], until=1.0, bounds=bounds, constraints=[limit], solver="trust-constr",
            second_order=given, **settings,
        )
        for given in (False, True)
    )  # fmt: skip
    assert exact.constraints["last"] == pytest.approx(-1.0, abs=1e-4)
    assert exact.value == pytest.approx(learnt.value, rel=1e-4)
    assert len(exact.history) < len(learnt.history)


def test_hessian_products_of_combined_responses() -> None:
    """The curvature of the function comes to that of its parts."""
    parts = [sr.Integral("energy.kinetic"), sr.Maximum("slider.velocity.x"), sr.Final("slider.x")]
    mixed = sr.Combined(lambda e, top, last: np.sqrt(e) / (top - last) ** 2, parts, name="mixed")
    names, equal = ["spring.k", "rod.mass"], sr.HHT(step=2e-3)
    p = sr.Problem(slider_crank(), mixed, names, until=0.9, method=replace(equal, rtol=1e-11))
    direction, e = np.array([1.0, -0.1]), 3e-3
    ends = [p.gradient(p.x0 + d * direction).matrix[0] for d in (e, -e)]
    assert np.allclose(p.hvp(p.x0, direction), (ends[0] - ends[1]) / (2 * e), rtol=1e-4)


def test_a_response_that_is_part_of_several_counts_once() -> None:
    """In one function twice, in another one, and alone twice."""
    x, v = sr.Final("slider.x"), sr.Final("slider.velocity.x")
    square, quotient = sr.Combined(lambda a, b: a * b, [x, x]), sr.Combined(lambda a, b: a / b, [v, x])
    outer = Composite([square, quotient, x, x])
    assert outer.parts == [x, v]
    values, slopes = outer.linear(np.array([3.0, 12.0]))
    assert values.tolist() == [9.0, 4.0, 3.0, 3.0]
    assert slopes.tolist() == [[6.0, 0.0], [-4 / 3, 1 / 3], [1.0, 0.0], [1.0, 0.0]]
    system, method = slider_crank(), sr.HHT(step=0.02)
    run = sr.simulate(system, until=0.3, method=method, store="steps")
    shared = sr.sensitivity(run, [square, quotient, x, x], ["rod.mass"])
    alone = sr.sensitivity(run, [x, v], ["rod.mass"]).matrix[:, 0]
    X, V = run["slider.x"][-1], run["slider.velocity.x"][-1]
    expected = [2 * X * alone[0], alone[1] / X - V * alone[0] / X**2, alone[0], alone[0]]
    assert shared.matrix[:, 0] == pytest.approx(expected, rel=1e-10)
    assert sr.sensitivity(run, [x, x], ["rod.mass"]).matrix[:, 0] == pytest.approx(alone[[0, 0]])
    curved = sr.Combined(lambda a, b: a * b, [sr.Final("slider.x"), sr.Final("slider.x")])
    assert sr.hessian(run, square, ["rod.mass"]).matrix == pytest.approx(
        sr.hessian(run, curved, ["rod.mass"]).matrix, rel=1e-10
    )


def test_ctrl_c_in_a_later_start_returns_the_best_design() -> None:
    """Also where that start has no design yet."""
    firsts: list[float] = []

    def stop(number: int, value: float) -> None:
        firsts.extend([value] * (number == 1))
        if len(firsts) == 2:
            raise KeyboardInterrupt

    found = sr.optimize(
        slider_crank(),
        "final(slider.x)",
        ["spring.k"],
        bounds={"spring.k": (10.0, 1000.0)},
        until=0.05,
        starts=3,
        iterations=2,
        progress=stop,
    )
    assert found.status == "stopped"
    assert not found.success
    assert found.message.startswith("stopped by the user")
    assert found.value <= firsts[0]
