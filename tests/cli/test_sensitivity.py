"""The verbs that differentiate: influences ranked, and best numbers from a file."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
from sarrus import mechanisms
from sarrus.cli import main
from sarrus.model import ModelError, load
from sarrus.model.written import with_numbers
from sarrus.studies.optimization import read_optimization_file

CRANK = str(mechanisms.path("slider_crank"))
SHORT = ["--until", "0.3", "--rtol", "1e-5", "--atol", "1e-7"]


def test_influences_are_ranked_and_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    figure = tmp_path / "tornado.png"
    wanted = ["--response", "slider.x", "max(slider.x) - min(slider.x)", "--wrt", "spring", "rod.mass"]
    assert main(["sensitivity", CRANK, *SHORT, *wanted, "--figure", str(figure)]) == 0
    told = capsys.readouterr().out
    assert "slider.x = " in told
    assert told.index("spring.length") < told.index("rod.mass")
    assert figure.stat().st_size > 10_000
    assert main(["sensitivity", CRANK, *SHORT, *wanted, "--json", "-q"]) == 0
    found = json.loads(capsys.readouterr().out)
    run = sr.simulate(sr.System(load(CRANK)), until=0.3, method=sr.Radau(rtol=1e-5, atol=1e-7), store="steps")
    direct = sr.sensitivity(run, "slider.x", found["names"], method="direct")
    assert np.allclose(found["responses"]["slider.x"]["gradient"], direct.matrix[0], rtol=1e-8, atol=1e-12)
    assert found["responses"]["slider.x"]["ranked"][:3] == direct.ranked()[:3]


def test_values_of_an_option_that_stands_twice_add_up(capsys: pytest.CaptureFixture[str]) -> None:
    twice = [
        "--response",
        "slider.x",
        "--response",
        "slider.velocity.x",
        "--wrt",
        "spring.k",
        "--wrt",
        "rod.mass",
    ]
    assert main(["sensitivity", CRANK, *SHORT, *twice, "--json", "-q"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (list(found["responses"]), found["names"]) == (
        ["slider.x", "slider.velocity.x"], ["spring.k", "rod.mass"],
    )  # fmt: skip


def test_a_response_that_is_no_number_is_an_answer_with_its_name(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sensitivity", CRANK, *SHORT, "--response", "sqrt(slider.x - 100)", "-q"]) == 1
    assert "is nan: its output leaves where it is defined" in capsys.readouterr().out


MISUSE = [
    ("--response 3", "names no output of the motion"),
    ("--response slider.w", "no output 'slider.w'"),
    ("--response slider.x --wrt spring.kk", "no parameter 'spring.kk'"),
    ("--response max(max(slider.x))", "a reduction in a reduction"),
    ("--response slider.x --figure a.xyz", "--figure: must end in"),
    ("--response max(slider.x", "max(slider.x"),
]


@pytest.mark.parametrize(("line", "sentence"), MISUSE, ids=[line for line, _ in MISUSE])
def test_misuse_is_one_sentence(line: str, sentence: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sensitivity", CRANK, "--until", "0.01", *line.split()]) == 2
    told = capsys.readouterr().err
    assert sentence in told
    assert told.startswith("sarrus: ")
    assert told.count("\n") == 1


BEST = """\
name: soft
model: crank.yaml
parameters:
  spring.k: {from: 5 N/m, to: 40}
  spring.c: {from: 0.5, to: 5, start: 2}
minimize: integral(slider.velocity.x**2)
constraints:
  last: {of: slider.velocity.x, upper: -1.0}
analysis: {type: simulate, until: 1.0, rtol: 1e-5, atol: 1e-7}
iterations: 20
"""
FIT = """\
model: crank.yaml
parameters: {spring.k: {start: 13}, rod.mass: {from: 0.2, start: 1.2}}
fit:
  - {of: slider.x, file: data.csv, column: slider.x, sigma: 1 mm}
noise: estimated
analysis: {type: simulate, until: 1.0, rtol: 1e-5, atol: 1e-7}
"""


def written(folder: Path, text: str) -> Path:
    (folder / "crank.yaml").write_text(Path(CRANK).read_text())
    run = sr.simulate(
        sr.System(load(CRANK)), until=1.0, t_eval=np.linspace(0, 1, 21), method=sr.Radau(rtol=1e-7, atol=1e-9)
    )
    run.to_csv(folder / "data.csv")
    (folder / "best.yaml").write_text(text)
    return folder / "best.yaml"


def test_best_numbers_from_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, figure, table = written(tmp_path, BEST), tmp_path / "c.png", tmp_path / "d.csv"
    assert main(["optimize", str(file), "--figure", str(figure), "--csv", str(table), "--json", "-q"]) == 0
    found = json.loads(capsys.readouterr().out)
    bounds = {"spring.k": (5.0, 40.0), "spring.c": (0.5, 5.0)}
    effort = sr.Integral(lambda o: o("slider.velocity.x") ** 2)
    limit = sr.Within("slider.velocity.x", upper=-1.0)
    same = sr.optimize(
        sr.System(load(CRANK)),
        effort,
        [*bounds],
        until=1.0,
        bounds=bounds,
        constraints=[limit],
        method=sr.Radau(rtol=1e-5, atol=1e-7),
    )
    assert found["objective"] == pytest.approx(same.value, rel=1e-3)
    assert found["constraints"]["last"] == pytest.approx(-1.0, abs=1e-4)
    assert figure.stat().st_size > 10_000
    assert len(table.read_text().splitlines()) == found["simulations"] + 1


def test_second_derivatives_from_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """They are handed on: SLSQP, which constraints ask for, takes none."""
    file = written(tmp_path, BEST.replace("iterations: 20", "solver: trust-constr\nsecond_order: true"))
    assert read_optimization_file(file, load).options == {"solver": "trust-constr", "second_order": True}
    file.write_text(BEST.replace("iterations: 20", "second_order: true"))
    assert main(["optimize", str(file), "-q"]) == 2
    assert "SLSQP does not use second derivatives. Choose trust-constr or IPOPT" in capsys.readouterr().err


def test_parameters_from_measurements_in_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["optimize", str(written(tmp_path, FIT)), "--json", "-q"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["numbers"]["spring.k"] == pytest.approx(10, rel=1e-2)
    assert found["numbers"]["rod.mass"] == pytest.approx(1, rel=1e-2)
    assert set(found["intervals"]) == {"spring.k", "rod.mass"}


WRONG = [
    (
        "minimize:",
        "minimise:",
        "best.yaml:6: an optimization has no key 'minimise'. Did you mean \"minimize\"?",
    ),
    ("spring.k:", "spring.kk:", "has no parameter 'spring.kk'"),
    ("{from: 5 N/m, to: 40}", "{from: 50, to: 40}", "best.yaml:4: parameters.spring.k: its limits must rise"),
    (
        "{from: 5 N/m, to: 40}",
        "{from: 5 kg, to: 40}",
        "best.yaml:4: parameters.spring.k: spring.k expects N/m, but '5 kg' is in kg. Give it in N/m",
    ),
    (
        "to: 5, start: 2}",
        "to: 5, start: 9}",
        "best.yaml:5: parameters.spring.c: its start 9 is not between 0.5 and 5",
    ),
    ("{from: 5 N/m, to: 40}", "{form: 5, to: 40}", "has no key 'form'. Did you mean \"from\"?"),
    ("upper: -1.0", "uper: -1.0", "has no key 'uper'"),
    (", upper: -1.0", "", "needs a lower or an upper limit"),
    (
        "type: simulate, until: 1.0, rtol: 1e-5, atol: 1e-7",
        "type: statics",
        "the analysis statics has one state without a history. Use final(...)",
    ),
    ("iterations: 20", "iterations: 0", "best.yaml:10: iterations: iterations must be a whole number"),
    ("iterations: 20", "solver: Newton", "there is no solver 'Newton'"),
    ("iterations: 20", "second_order: maybe", "best.yaml:10: second_order: second_order is true or false"),
    ("iterations: 20", "noise: given", "best.yaml:10: 'noise' belongs to 'fit'"),
    ("iterations: 20", "fit: []", "one of minimize and fit is needed"),
    ("minimize: integral(", "minimize: integrate(", "best.yaml:6: minimize:"),
]


@pytest.mark.parametrize(("right", "wrong", "sentence"), WRONG, ids=[wrong for _, wrong, _ in WRONG])
def test_what_is_wrong_in_a_file_is_told_with_its_line(
    right: str, wrong: str, sentence: str, tmp_path: Path
) -> None:
    assert right in BEST
    (tmp_path / "crank.yaml").write_text(Path(CRANK).read_text())
    (tmp_path / "best.yaml").write_text(BEST.replace(right, wrong))
    with pytest.raises(ModelError) as told:
        read_optimization_file(tmp_path / "best.yaml", load)
    assert sentence in str(told.value)
    assert "\n" not in str(told.value)


OTHERS = [
    ("{type: statics}", "(slider.x - 4.7)**2", "spring.length", {}),
    ("{type: modes}", "(mode1.natural_frequency - 0.41)**2", "spring.k", {}),
    ("{type: linearization}", "(A[pin.angle.rate, pin.angle] + 6)**2", "spring.k", {"last": "slider.x"}),
    ("{type: kinematics, until: 1, steps: 10}", "(max(slider.x) - 4.9)**2", "pin.point.z", {}),
    ("{type: inverse_dynamics, motion: moved.sarrus}", "(at(motor.torque.x, 0.5) + 3)**2", "spring.k", {}),
]


@pytest.mark.one_in(4)
@pytest.mark.filterwarnings("ignore:.*assembly changed")
@pytest.mark.parametrize(("analysis", "goal", "name", "limits"), OTHERS, ids=[one[0] for one in OTHERS])
def test_other_analyses_in_a_file(
    analysis: str, goal: str, name: str, limits: dict[str, str], tmp_path: Path
) -> None:
    """The goal is reached: its square is zero."""
    model = load(CRANK)
    if "kinematics" in analysis or "inverse" in analysis:
        sr.simulate(sr.System(model), until=1.0, t_eval=np.linspace(0, 1, 11), save=tmp_path / "moved.sarrus")
        model = replace(model, drivers=[sr.AngleDriver("motor", "pin", "3*t")])
    model.save(tmp_path / "crank.yaml")
    constraints = {key: {"of": of, "lower": 1.0} for key, of in limits.items()}
    lines = [
        "model: crank.yaml",
        f"parameters: {{{name}: {{}}}}",
        f"minimize: {goal}",
        f"analysis: {analysis}",
    ]
    (tmp_path / "best.yaml").write_text("\n".join([*lines, f"constraints: {json.dumps(constraints)}"]))
    found = read_optimization_file(tmp_path / "best.yaml", load).solved()
    assert found.value < 1e-8 * found.value0
    assert all(found.constraints[key] > 1.0 for key in limits)


def test_an_equilibrium_is_fitted_in_a_file(tmp_path: Path) -> None:
    (tmp_path / "crank.yaml").write_text(Path(CRANK).read_text())
    rest = sr.equilibrium(sr.System(with_numbers(load(CRANK), {"spring.k": 13.0})))
    (tmp_path / "data.csv").write_text(f"t,slider.x\n0,{rest['slider.x']!r}\n")
    text = "model: crank.yaml\nparameters: {spring.k: {start: 11}}\nanalysis: {type: statics}\n"
    (tmp_path / "fit.yaml").write_text(text + "fit:\n  - {of: slider.x, file: data.csv, sigma: 1 mm}\n")
    assert read_optimization_file(tmp_path / "fit.yaml", load).solved().x == pytest.approx([13.0], rel=1e-5)


def test_a_missing_column_is_named(tmp_path: Path) -> None:
    file = written(tmp_path, FIT.replace("slider.x", "slider.q"))
    with pytest.raises(ModelError, match=r"has no column 'slider.q'"):
        read_optimization_file(file, load)


def test_the_shell_has_the_tolerances_of_python() -> None:
    """One default, from one place, of everything that simulates: that of the method."""
    from sarrus.cli import shared
    from sarrus.cli.parser import build
    from sarrus.defaults import ATOL, RTOL, RTOL_OF_ORDER_2

    for line in (["run", "slider_crank"], ["sensitivity", "slider_crank", "--response", "slider.x"]):
        chosen = build(line[:1]).parse_args(line)
        assert shared.method_of(chosen) == sr.Radau()
        chosen = build(line[:1]).parse_args([*line, "--method", "hht", "--rtol", "1e-4", "--atol", "1e-5"])
        assert shared.method_of(chosen) == sr.HHT(rtol=1e-4, atol=1e-5)
    assert (sr.Radau().rtol, sr.HHT().rtol, sr.Radau().atol) == (RTOL, RTOL_OF_ORDER_2, ATOL)
