"""Formulas of outputs, and outputs that a model names, wherever an output or a response is given."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from tests.workspace.mechanisms import arm_2r

import sarrus as sr
from sarrus.cli import main
from sarrus.outputs import UnknownOutput

X0, K, M, UNTIL = 0.1, 30.0, 2.0, 1.3
OMEGA = np.sqrt(K / M)
NAMED = {"twice": "2*a.x", "far": "twice - a.y + 1 m"}
SETTINGS = {"until": UNTIL, "method": sr.Radau(rtol=1e-10, atol=1e-12)}


def model(**more: object) -> sr.Model:
    """A mass on a spring: x = x₀ cos ωt."""
    a = sr.Body("a", mass=M, inertia=(1, 1, 1), position=(X0, 0, 0))
    slide = sr.Translational("slide", sr.ground, a, axis=(1, 0, 0), point=(0, 0, 0))
    spring = sr.TSDA("spring", sr.ground.point(-2, 0, 0), a.point(0, 0, 0), k=K, length=2.0)
    return sr.Model("oscillator", [a], [slide], [spring], **{"outputs": NAMED, **more})


@cache
def run() -> sr.Trajectory:
    return sr.simulate(sr.System(model()), t_eval=np.linspace(0, UNTIL, 14), store="steps", **SETTINGS)


@pytest.mark.parametrize(
    ("text", "unit", "of_x"),
    [
        ("2*a.x", "m", lambda x: 2 * x),
        ("twice", "m", lambda x: 2 * x),
        ("far", "m", lambda x: 2 * x + 1),
        ("twice*a.x - 1 cm^2", "m²", lambda x: 2 * x * x - 1e-4),
        ("spring.k*a.x", "N", lambda x: K * x),
    ],
)
def test_values_units_labels_and_columns(
    text: str, unit: str, of_x: Callable[[np.ndarray], np.ndarray], tmp_path: Path
) -> None:
    wanted = of_x(X0 * np.cos(OMEGA * run().t))
    assert run()[text] == pytest.approx(wanted, abs=1e-8)
    assert (run().output(text).unit, run().output(text).label) == (unit, f"{text} [{unit}]")
    assert run().output(text, rate=True).values == pytest.approx(
        (of_x(run()["a.x"] + 1e-6 * run()["a.velocity.x"]) - of_x(run()["a.x"])) * 1e6, abs=1e-3
    )
    assert run().plot(text, ax=Figure().subplots()).lines[0].get_ydata() == pytest.approx(wanted, abs=1e-8)
    run().to_csv(tmp_path / "run.csv", text)
    assert np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1)[:, 1] == pytest.approx(
        wanted, abs=1e-8
    )


def test_derivatives_of_formulas_with_reductions() -> None:
    """Those of max(v)/(2 x₀) = ω/2, of the final value x₀ cos ωT, of the mean x₀ sin(ωT)/ωT, and of their product."""
    late = (
        "max(a.velocity.x)/initial(twice)",
        "far",
        "mean(a.x)",
        sr.At("twice*a.x", time=UNTIL),
        sr.Integral("2*a.x"),
    )
    found = sr.sensitivity(run(), late, ["spring.k"], error=True)
    slope, c, s = OMEGA / (2 * K), np.cos(OMEGA * UNTIL), np.sin(OMEGA * UNTIL)
    mean = X0 * s / (OMEGA * UNTIL)
    by_omega = [1 / 2, -2 * X0 * UNTIL * s, X0 * c / OMEGA - mean / OMEGA, -4 * X0**2 * c * s * UNTIL]
    by_omega.append(2 * UNTIL * by_omega[2])
    assert found.values == pytest.approx(
        [OMEGA / 2, 2 * X0 * c + 1, mean, 2 * X0**2 * c * c, 2 * mean * UNTIL], abs=1e-7
    )
    assert found.matrix[:, 0] == pytest.approx(slope * np.array(by_omega), abs=1e-7)
    assert found.responses[0] == late[0]
    assert found.response_units[::2] == ("1/s", "m", "m s")
    assert found.errors[0].value == found.values[0]
    assert run().error("max(twice) - min(twice)").value == pytest.approx(4 * X0, abs=1e-7)


def test_second_derivatives_of_a_formula() -> None:
    """Of (x₀ cos ωT)² as a product of two responses, and as an output."""
    want = (
        -(X0**2)
        * UNTIL
        * (np.cos(2 * OMEGA * UNTIL) * 2 * UNTIL - np.sin(2 * OMEGA * UNTIL) / OMEGA)
        / (4 * K * M)
    )
    for text in ("final(a.x)*a.x", "final(a.x**2)"):
        found = sr.hessian(run(), text, ["spring.k"])
        assert found["spring.k", "spring.k"] == pytest.approx(want, rel=1e-6)
        product = sr.hessian_product(run(), text, {"spring.k": 1.0})
        assert product[0] == pytest.approx(want, rel=1e-6)


def test_mean_of_a_run_that_an_event_ends() -> None:
    """The mean height of a dropped body is 2/3 of that at the start, and its slope 2/3: the end moves."""
    ball = sr.Body("ball", mass=1.0, inertia=(1, 1, 1), position=(0, 0, 1.0))
    system = sr.System(sr.Model("drop", [ball], gravity=(0, 0, -10.0), outputs={"height": "ball.z"}))
    end = sr.Event("2*height", terminal=True, name="ground")
    drop = sr.simulate(system, until=2.0, events=[end], store="steps", method=sr.Radau())
    found = sr.sensitivity(drop, ["mean(ball.z)", "initial(height)"], ["ball.position.z"])
    assert found.values == pytest.approx([2 / 3, 1], abs=1e-9)
    assert found.matrix[:, 0] == pytest.approx([2 / 3, 1], abs=1e-8)


def test_optimization_and_studies() -> None:
    system = sr.System(model())
    best = sr.optimize(system, "(at(twice, 1) + 0.15)**2", ["spring.k"], until=UNTIL)
    assert 2 * X0 * np.cos(np.sqrt(best.x[0] / M)) == pytest.approx(-0.15, abs=1e-3)
    found = sr.study(
        model(), {"spring.k": [K]}, {"top": "max(far) + spring.k*0"}, analysis=sr.Simulation(UNTIL)
    )
    assert found["top"][0] == pytest.approx(2 * X0 + 1)


def test_linearization_and_workspace() -> None:
    system = sr.System(model())
    plant = sr.linearize(system, sr.assemble(system), outputs=["a.x", "twice", "3*a.velocity.x"])
    assert plant.C[1] == pytest.approx(2 * plant.C[0])
    assert abs(plant.C[2]).max() == pytest.approx(3)
    system, output, limits = arm_2r()
    x, y = (function.label for function in output)
    plain = sr.workspace(system, output, limits=limits, verify=False)
    double = sr.workspace(system, (f"2*{x}", f"{y} + 1"), limits=limits, verify=False)
    assert double.area == pytest.approx(2 * plain.area, rel=1e-6)


def test_names_are_saved_loaded_and_included(tmp_path: Path) -> None:
    model().save(tmp_path / "model.yaml")
    loaded = sr.load(tmp_path / "model.yaml")
    assert loaded.outputs == NAMED
    (tmp_path / "two.yaml").write_text(
        "include: [{file: model.yaml, prefix: l_}, {file: model.yaml, prefix: r_}]\n"
        "bodies: {}\noutputs: {gap: l_far - r_twice}\n"
    )
    two = sr.simulate(sr.System(sr.load(tmp_path / "two.yaml")), until=0.01)
    assert two["gap"][0] == pytest.approx(1.0)
    run().save(tmp_path / "run.sarrus")
    assert sr.load_run(tmp_path / "run.sarrus", sr.System(loaded))["far"] == pytest.approx(run()["far"])


def test_the_shell_takes_formulas(tmp_path: Path) -> None:
    model().save(tmp_path / "model.yaml")
    table, figure = tmp_path / "run.csv", tmp_path / "run.png"
    asked = [
        "--columns",
        "2*a.x",
        "far",
        "--plot",
        "far - twice",
        "--csv",
        str(table),
        "--figure",
        str(figure),
    ]
    assert main(["run", str(tmp_path / "model.yaml"), "--until", "0.1", *asked]) == 0
    assert table.read_text().startswith("t [s],2*a.x [m],far [m]")
    assert figure.exists()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "max(a.x)",
            "max(a.x) is one number of a whole run, not an output at each time. Use 'max(a.x)' as a response.",
        ),
        ("2*a.xx", "oscillator has no output 'a.xx'. Did you mean \"a.x\"?"),
        ("2*", "holds a formula in which a number or a name is missing"),
        ("foo(a.x)", 'calls the unknown function "foo"'),
        ("a.xx", 'Did you mean "a.x"?'),
        ("fur", "Did you mean"),
    ],
)
def test_messages(text: str, message: str) -> None:
    with pytest.raises(UnknownOutput) as refused:
        run().output(text)
    assert message in str(refused.value)


@pytest.mark.parametrize(
    ("outputs", "message"),
    [
        ({"a": "2*a.x"}, 'the name "a" is that of an output or a part'),
        ({"one": "two", "two": "one + 1"}, "circular formulas: one → two → one"),
        ({"one": "2*"}, "holds a formula in which"),
        ({"one": 3}, "must be a formula of outputs"),
        ([1], "outputs must be a mapping"),
    ],
)
def test_wrong_names_are_refused(outputs: object, message: str) -> None:
    with pytest.raises(sr.ModelError) as refused:
        sr.System(model(outputs=outputs))
    assert message in str(refused.value)


def test_the_check_of_a_model_names_wrong_formulas(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model(outputs={"far": "2*a.xx"}).save(tmp_path / "model.yaml")
    assert main(["check", str(tmp_path / "model.yaml")]) != 0
    assert "outputs: far: oscillator has no output 'a.xx'. Did you mean \"a.x\"?" in capsys.readouterr().err
