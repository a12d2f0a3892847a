"""Eight mechanisms whose gradients and Hessians are known: errors fall with the tolerance, whatever the method."""

import json
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any

import numpy as np
import pytest
from tests.prescribed_steps import run_of
from tests.sensitivity import cases
from tests.sensitivity.cases import Case
from tests.sensitivity.test_references import FOLDER

import sarrus as sr

pytestmark = pytest.mark.filterwarnings("ignore:.*assembly changed")  # states here are drawn roughly


@dataclass(frozen=True)
class Known:
    """A case, and what of its motion is known: values, gradients (r, p), Hessians by the response's name."""

    case: Case
    values: np.ndarray
    gradient: np.ndarray
    hessians: dict[str, np.ndarray]


FILES = {
    "oscillator": "S01_oscillator",
    "pendulum": "S02_pendulum_fixed_time",
    "double_pendulum": "S03_double_pendulum",
    "four_bar": "S05_fourbar",
    "five_bar": "S06_fivebar",
    "spatial_slider_crank": "S07_spatial_slider_crank",
    "free_top": "S08_free_top",
    "heavy_top": "S09_heavy_top",
}


def file(name: str) -> str:
    return (FOLDER / f"{FILES[name]}.json").read_text()


@cache
def known(name: str) -> Known:
    """What other programs, or closed forms, say."""
    case = getattr(cases, name)()
    told = json.loads(file(name))
    values = np.array([float(told["psi"][r]) for r in case.responses])
    gradient = np.array([[float(x) for x in told["grad"][r].values()] for r in case.responses])
    hessians = {r: np.array(h, dtype=float) for r, h in told.get("hess", {}).items() if r in case.responses}
    return Known(case, values, gradient, hessians)


def errors(name: str, tolerance: float, **settings: object) -> np.ndarray:
    """Of values and gradients (r, 2), relative to the largest entry of each response."""
    told = known(name)
    run = told.case.run(tolerance=tolerance, **settings)
    found = told.case.gradient(run)
    rows = abs(found.matrix - told.gradient).max(axis=1) / abs(told.gradient).max(axis=1)
    return np.column_stack([abs(found.values - told.values) / abs(told.gradient).max(axis=1), rows])


# the largest error of values and gradients with HHT at a tolerance of 1e-8, and with Radau at 1e-9
REACHED = {
    "oscillator": (6e-4, 3e-8),
    "pendulum": (4e-4, 1e-8),
    "double_pendulum": (2e-4, 1e-8),
    "four_bar": (2e-3, 6e-8),
    "five_bar": (2e-5, 3e-9),
    "spatial_slider_crank": (2e-4, 2e-8),
    "free_top": (4e-4, 3e-8),
    "heavy_top": (5e-4, 5e-8),
}


@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", REACHED)
def test_gradients_with_hht(name: str) -> None:
    """Steps of order 2: a tolerance a hundred times as small, an error some twenty times as small."""
    coarse, middle, fine = (errors(name, tolerance)[:, 1] for tolerance in (1e-4, 1e-6, 1e-8))
    assert np.all(coarse > 4 * middle), (coarse, middle)
    assert np.all(middle > 8 * fine), (middle, fine)
    assert fine.max() < REACHED[name][0], fine


@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", REACHED)
def test_gradients_with_radau(name: str) -> None:
    """The same in many digits, integrals over few and long steps, too, of positions and of a force."""
    found = [errors(name, tolerance, method=sr.Radau()) for tolerance in (1e-5, 1e-7, 1e-9)]
    worst = [each.max() for each in found]
    assert worst[0] > 5 * worst[1] > 50 * worst[2], found
    assert worst[2] < REACHED[name][1], found[2]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "method", "longest"),
    [
        ("four_bar", sr.HHT, 2e-3),  # with longer steps the slope is 2.10
        ("four_bar", partial(sr.GeneralizedAlpha, 0.8), 4e-3),
        ("spatial_slider_crank", sr.HHT, 4e-3),
        ("spatial_slider_crank", partial(sr.GeneralizedAlpha, 0.8), 4e-3),
    ],
)
def test_gradients_approach_those_of_the_continuous_motion_with_order_two(
    name: str, method: Any, longest: float
) -> None:
    steps = longest / 2.0 ** np.arange(3)
    found = [errors(name, 1e-8, method=method(step=h))[:, 1].max() for h in steps]
    slopes = np.log2(np.array(found[:-1]) / found[1:])
    assert abs(slopes - 2).max() < 0.1, (found, slopes)


def test_gradients_approach_those_of_the_continuous_motion_with_order_five() -> None:
    told, found = known("double_pendulum"), []
    for count in (100, 200, 400):
        lengths = np.full(count, told.case.until / count)
        settings = {"rtol": 1e-9, "atol": 1e-9, "store_steps": True, "given": lengths}
        system = told.case.system
        run = run_of(sr.Radau(), system, sr.assemble(system), np.array([0.0, told.case.until]), **settings)
        found.append(abs(told.case.gradient(run).matrix - told.gradient).max())
    slopes = np.log2(np.array(found[:-1]) / found[1:])
    assert abs(slopes - 5).max() < 0.5, (found, slopes)


@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", REACHED)
def test_forwards_it_is_the_same(name: str) -> None:
    case = known(name).case
    run = case.run(tolerance=1e-4)
    back, forward = (case.gradient(run, method).matrix for method in ("adjoint", "direct"))
    assert abs(forward - back).max() < 1e-9 * abs(back).max()


CURVED = {
    "oscillator": ["x_T", "v_T", "int_x2"],
    "pendulum": ["rod_tension", "int_tension2"],
    "double_pendulum": ["tip_r2", "int_KE"],
    "free_top": ["e2", "w1_T", "int_A33"],
}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", CURVED)
def test_hessians(name: str) -> None:
    told, found = known(name), []
    for tolerance in (1e-4, 1e-6):
        run = told.case.run(tolerance=tolerance)
        hessians = {r: told.case.hessian(run, r) for r in CURVED[name]}
        found.append(
            [
                abs(h.matrix - told.hessians[r]).max() / abs(told.hessians[r]).max()
                for r, h in hessians.items()
            ]
        )
        assert max(h.asymmetry for h in hessians.values()) < 1e-9
    assert np.all(np.array(found[0]) > 5 * np.array(found[1])), found
    assert max(found[1]) < 1e-3, found


def test_a_hessian_is_printed_as_a_table() -> None:
    case = known("oscillator").case
    found = case.hessian(case.run(tolerance=1e-4), "int_x2", ["m", "k"])
    lines = str(found).splitlines()
    assert lines[1].split() == ["m", "k"]
    assert [float(x) for x in lines[3].split()[1:]] == pytest.approx(
        [found["k", "m"], found["k", "k"]], rel=1e-5
    )
    with pytest.raises(KeyError, match=r"no second derivative with respect to 'c'. Choose from m, k"):
        found["k", "c"]


@pytest.mark.slow
def test_the_five_bar_has_a_large_hessian_by_its_springs() -> None:
    case, wanted = known("five_bar").case, np.array(json.loads(file("five_bar"))["hess_J"])
    found = [
        case.hessian(case.run(tolerance=tolerance), "J", ["L01", "L02"]).matrix for tolerance in (1e-5, 1e-7)
    ]
    error = [abs(one - wanted).max() / abs(wanted).max() for one in found]
    assert error[0] > 8 * error[1], error
    assert error[1] < 2e-4, error


def test_gradients_of_a_long_motion_grow() -> None:
    """Over 5 s the five-bar's derivatives by the springs are seven times as large as over 2 s."""
    case, told = known("five_bar").case, json.loads(file("five_bar"))["over_5_s"]
    found = [
        case.gradient(case.run(tolerance=rtol, until=5.0, t_eval=[5.0], method=sr.Radau()))
        for rtol in (1e-6, 1e-8)
    ]
    wanted = np.array(list(told["grad"].values()))
    error = [abs(one.matrix[0] - wanted).max() / abs(wanted).max() for one in found]
    assert found[1].values[0] == pytest.approx(told["J"], rel=1e-6)
    assert error[0] > 8 * error[1], error
    assert error[1] < 1e-6, error


def test_the_stretch_of_a_spring_whose_length_is_asked_for() -> None:
    """What is measured from the free length depends on it also by itself."""
    told = known("spatial_slider_crank")
    own = sr.Integral(lambda o: (o("spring.length") - o.parameter("l0")) ** 2, name="own")
    mean = sr.Integral(lambda o: -2 * (o("spring.length") - 5), name="mean")
    case = replace(
        told.case, responses={"int_stretch2": told.case.responses["int_stretch2"], "own": own, "mean": mean}
    )
    found = case.gradient(case.run(tolerance=1e-6))
    from_5_m, own, _ = found["l0"]
    assert own == pytest.approx(from_5_m + found.values[2], rel=1e-10)


@pytest.mark.parametrize("row", range(4))
def test_the_period_of_a_pendulum(row: int) -> None:
    """Four times what it takes to hang straight down, by the event that ends the run there."""
    told = json.loads((FOLDER / "S02_pendulum_period.json").read_text())["cases"][row]
    case = cases.pendulum(float(told["params"]["theta0"]))
    down = sr.Event("bob.x", direction=-1, terminal=True)
    wanted, found = np.array([float(told["grad"][name]) for name in ("L", "g", "theta0")]), []
    for tolerance in (1e-6, 1e-8):
        run = case.run(until=2.0, t_eval=None, events=down, tolerance=tolerance)
        named = {"design": case.design, "formula": case.formula}
        quarter = sr.sensitivity(run, sr.Final("t"), ["L", "g", "theta0", "m"], **named)
        assert quarter.matrix[0, 3] == pytest.approx(0, abs=tolerance)
        found.append(abs(4 * quarter.matrix[0, :3] - wanted).max() / abs(wanted).max())
    assert 4 * quarter.values[0] == pytest.approx(float(told["period"]), rel=5e-5)
    assert found[0] > 8 * found[1], found
    assert found[1] < 1e-4, found
