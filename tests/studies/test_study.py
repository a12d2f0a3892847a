"""Studies of the slider-crank: right, repeatable, resumable, and never stopped by a case."""

import json
import subprocess
import sys
import textwrap
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.studies import own

import sarrus as sr
from sarrus.model import Model, SarrusError
from sarrus.studies import Grid, Kinematics, Range, Simulation, Sobol, Statics, Vibration, open_study, study
from sarrus.studies.ledger import CASES, STUDY

SHORT = Simulation(until=0.2, steps=50)
K = {"spring.k": [5, 13, 20]}
RESTS = (
    7.36534649e-04,
    1.96982619,
)  # heights of the crank in which all forces balance, the stable one first [m]


def test_a_study_is_what_single_runs_give(model: Model) -> None:
    found = study(
        model,
        {"spring.k": [5, 20], "rod.mass": [0.5, 2.0]},
        {"end": "slider.x", "least": "min(slider.x)", "load": "max(abs(pin.force.z))", "twice": "2*spring.k"},
        analysis=SHORT,
        workers=1,
    )
    assert found.success.all()
    for case in (0, 3):
        k, mass = found.values[case]
        bodies = [sr.Body(**{**vars(b), "mass": mass}) if b.name == "rod" else b for b in model.bodies]
        springs = [sr.TSDA(**{**vars(f), "k": k}) for f in model.forces]
        from dataclasses import replace

        run = sr.simulate(
            sr.System(replace(model, bodies=bodies, forces=springs)),
            until=0.2,
            t_eval=np.linspace(0, 0.2, 51),
        )
        x, z = run.coordinate("slider.x"), run.reaction("pin").force[:, 2]
        assert found.case(case) == {
            "spring.k": k,
            "rod.mass": mass,
            "end": pytest.approx(x[-1], rel=1e-13),
            "least": pytest.approx(x.min(), rel=1e-13),
            "load": pytest.approx(abs(z).max(), rel=1e-9),
            "twice": 2 * k,
        }


def test_statics_and_modes(model: Model) -> None:
    rest = study(model, K, {"x": "slider.x"}, analysis=Statics(), workers=1)
    wanted = [sr.equilibrium(sr.System(_with_k(model, k))).q[14] for k in (5, 13, 20)]
    assert rest["x"] == pytest.approx(wanted, rel=1e-9)
    found = study(model, K, {"f": "mode1.frequency"}, analysis="modes", workers=1)
    assert np.all(np.diff(found["f"]) > 0)
    assert study(model, {"spring.k": [10]}, "mode1.frequency", analysis=Vibration(), workers=1)[
        "mode1.frequency"
    ] == pytest.approx([0.407188], abs=1e-3)


def _with_k(model: Model, k: float) -> Model:
    from dataclasses import replace

    return replace(model, forces=[sr.TSDA(**{**vars(f), "k": k}) for f in model.forces])


def test_many_starts_find_every_rest(model: Model) -> None:
    places = {f"start.q.{body}.r.{axis}": Range(-3, 3) for body in ("crank", "rod") for axis in "yz"}
    turns = {f"start.q.crank.p.e{k}": Range(-1, 1) for k in (0, 1)}
    found = study(model, places | turns, {"z": "crank.z"}, analysis=Statics(), sample=Sobol(16, 1), workers=1)
    kinds = found.distinct("z")
    assert sum(count for _, count in kinds) == 16
    assert found["z"][[case for case, _ in kinds]] == pytest.approx(RESTS[: len(kinds)], abs=1e-5)
    either = study(
        model, places | turns, "crank.z", analysis=Statics(stable=False), sample=Sobol(16, 1), workers=1
    )
    assert sorted(either["crank.z"][[case for case, _ in either.distinct()]]) == pytest.approx(
        sorted(RESTS), abs=1e-5
    )


def test_parameters_of_a_file_follow_everywhere(tmp_path: Path) -> None:
    text = """
name: pendulum
gravity: [0, 0, -9.81]
parameters: {l: 1 m, speed: 2}
bodies:
  bob: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, -l]}
joints:
  pin: {type: revolute, bodies: [ground, bob], point: [0, 0, 0], axis: [0, 1, 0]}
drivers:
  motor: {type: angle, joint: pin, motion: speed*t}
"""
    (tmp_path / "pendulum.yaml").write_text(text)
    found = study(
        sr.load(tmp_path / "pendulum.yaml"),
        {"l": ["50 cm", 2], "speed": [1, 3]},
        {"angle": "pin.angle", "z": "bob.z"},
        analysis={"type": "kinematics", "until": 0.5, "steps": 10},
        workers=1,
    )
    l, speed = found.values.T
    assert found["angle"] == pytest.approx(speed * 0.5, abs=1e-9)
    assert found["z"] == pytest.approx(-l * np.cos(speed * 0.5), abs=1e-9)


def test_failures_have_their_sentence_and_stop_nothing(model: Model) -> None:
    found = study(model, K, {"k": "k"}, analysis=own.picky, workers=1)
    assert found.success.tolist() == [True, False, True]
    assert found.failures == {1: "ZeroDivisionError: thirteen"}
    assert found["k"] == pytest.approx([5, np.nan, 20], nan_ok=True)
    wrong = study(model, {"rod.mass": [1, -1]}, "slider.x", analysis=SHORT, workers=1)
    assert "mass must be greater than 0, but is -1" in wrong.failures[1]
    assert wrong.success[0]


def test_a_case_may_not_take_forever(model: Model) -> None:
    found = study(model, K, "slider.x", analysis=Simulation(until=50), time_limit=0.01, workers=1)
    assert "took longer than it may" in found.failures[0]


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"parameters": {"spring.l": [1]}}, "has no parameter 'spring.l'. Did you mean"),
        ({"parameters": {"spring.k": "five"}}, "parameter 'spring.k'"),
        ({"responses": {}}, "needs a response"),
        ({"analysis": {"type": "simulate"}}, "needs an end time"),
        ({"analysis": {"type": "simulat"}}, "there is no analysis 'simulat'. Did you mean"),
        ({"analysis": {"type": "simulate", "until": 1, "method": "euler"}}, "there is no method 'euler'"),
        ({"analysis": {"type": "simulate", "until": 1, "method": "event"}}, "there is no method 'event'"),
        ({"workers": 0}, "workers must be 1 at least"),
    ],
)
def test_misuse_is_refused_before_anything_is_run(model: Model, change: dict[str, Any], told: str) -> None:
    asked: dict[str, Any] = {"parameters": K, "responses": "slider.x", "analysis": SHORT} | change
    with pytest.raises(SarrusError, match=told):
        study(model, asked.pop("parameters"), asked.pop("responses"), **asked)


@pytest.mark.parametrize("analysis", [SHORT, Statics(), Vibration(), Kinematics(until=0.1)])
def test_an_unknown_output_is_refused_before_any_case_is_run(model: Model, analysis: Any) -> None:
    """Not as the message of every case, after all of them were run."""
    done: list[int] = []
    with pytest.raises(SarrusError, match=r"response 'reach': .* has no output 'slider\.w'"):
        study(model, K, {"k": "spring.k", "reach": "max(slider.w)"}, analysis=analysis, progress=done.append)
    assert not done


def test_times_after_the_end_and_values_that_are_no_numbers_are_refused_at_once(model: Model) -> None:
    for late in ("99", "-1", "9*11"):
        with pytest.raises(SarrusError, match="times must be between 0 and"):
            study(model, K, f"at(slider.x, {late})", analysis=SHORT)
    with pytest.raises(SarrusError, match=r"'spring\.k': listed values must be finite"):
        study(model, {"spring.k": [10.0, float("nan")]}, "slider.x", analysis=SHORT)


def test_any_executor(model: Model) -> None:
    with ThreadPoolExecutor(2) as threads:
        found = study(model, K, {"k": "k"}, analysis=own.quick, executor=threads)
    assert found["k"].tolist() == [5, 13, 20]


def test_processes_give_the_same_numbers_in_order(model: Model) -> None:
    asked: dict[str, Any] = {"analysis": SHORT, "sample": Sobol(8, 2)}
    here, there = (study(model, {"spring.k": Range(5, 20)}, "slider.x", workers=n, **asked) for n in (1, 2))
    assert np.array_equal(here.values, there.values)
    assert np.array_equal(here.found, there.found)


@pytest.mark.slow
def test_a_case_that_kills_its_worker_is_the_only_one_that_fails(model: Model) -> None:
    asked = {"spring.k": [*range(5, 25)]}
    found = study(model, asked, {"k": "k"}, analysis=own.deadly, workers=2)
    assert found.failures == {8: "its worker process died, twice. Give it more memory."}


@pytest.mark.slow
def test_a_killed_worker_loses_nothing(model: Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SARRUS_TEST_MARK", str(tmp_path / "died"))
    found = study(model, {"spring.k": [*range(5, 25)]}, {"k": "k"}, analysis=own.dies_once, workers=2)
    assert (tmp_path / "died").exists()
    assert found["k"].tolist() == [*range(5, 25)]


def test_results_come_back_from_the_folder(model: Model, tmp_path: Path) -> None:
    found = study(model, K, "slider.x", analysis=SHORT, folder=tmp_path / "s", workers=1)
    again = open_study(tmp_path / "s")
    assert np.array_equal(again.found, found.found)
    assert again.facts["sample"] == {"type": "grid"}
    assert again.facts["versions"]["sarrus"] == sr.__version__
    copy = sr.load(tmp_path / "s" / "model" / "slider_crank.yaml")
    assert np.array_equal(sr.System(copy).b, sr.System(model).b)


def test_a_study_goes_on_where_it_was(model: Model, tmp_path: Path) -> None:
    asked: dict[str, Any] = {"analysis": SHORT, "folder": tmp_path, "workers": 1}
    whole = study(model, K, "slider.x", **asked)
    lines = (tmp_path / CASES).read_bytes().splitlines(keepends=True)
    (tmp_path / CASES).write_bytes(lines[0] + lines[1] + lines[2][:-9])  # the last one torn by a crash
    done: list[int] = []
    again = study(model, K, "slider.x", progress=done.append, **asked)
    assert done == [3]
    assert np.array_equal(again.found, whole.found)
    assert len((tmp_path / CASES).read_bytes().splitlines()) == 3


def test_failed_cases_can_be_run_again(model: Model, tmp_path: Path) -> None:
    asked: dict[str, Any] = {"analysis": own.picky, "folder": tmp_path, "workers": 1}
    study(model, K, {"k": "k"}, **asked)
    done: list[int] = []
    study(model, K, {"k": "k"}, progress=done.append, **asked)
    assert done == []
    study(model, K, {"k": "k"}, progress=done.append, retry_failed=True, **asked)
    assert done == [3]


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"parameters": {"spring.k": [1, 2, 3]}}, "parameters"),
        ({"responses": "slider.y"}, "responses"),
        ({"analysis": Simulation(until=0.3)}, "analysis"),
        ({"model": "mass"}, "model"),
    ],
)
def test_a_folder_holds_one_study(model: Model, tmp_path: Path, change: dict[str, Any], what: str) -> None:
    asked: dict[str, Any] = {"parameters": K, "responses": "slider.x", "analysis": SHORT}
    study(model, **asked, folder=tmp_path, workers=1)
    if change.pop("model", None):
        model = _with_k(model, 11.0)
    with pytest.raises(SarrusError, match=f"another {what}"):
        study(model, **(asked | change), folder=tmp_path, workers=1)


@pytest.mark.slow
def test_a_study_killed_at_any_moment_goes_on(tmp_path: Path) -> None:
    program = textwrap.dedent(f"""
        from sarrus import mechanisms, load
        from sarrus.studies import study
        from tests.studies import own
        study(load(mechanisms.path("slider_crank")), {{"spring.k": [*range(5, 65)]}}, {{"k": "k"}},
              analysis=own.slow, folder={str(tmp_path / "s")!r}, workers=2)
    """)
    root = Path(__file__).parent.parent.parent
    running = subprocess.Popen([sys.executable, "-c", program], cwd=root)
    place = tmp_path / "s" / CASES
    while not place.exists() or place.stat().st_size < 300:
        assert running.poll() is None
        time.sleep(0.02)
    running.kill()
    running.wait()
    before = len(place.read_bytes().splitlines())
    assert 0 < before < 60
    done = subprocess.run([sys.executable, "-c", program], cwd=root, check=False)
    assert done.returncode == 0
    cases = [json.loads(line)["case"] for line in place.read_bytes().splitlines()]
    assert sorted(set(cases)) == list(range(60))
    assert len(cases) == 60
    assert open_study(tmp_path / "s")["k"].tolist() == [*range(5, 65)]


@pytest.mark.slow
def test_a_script_needs_no_guard(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        "import sarrus as sr\n"
        "from sarrus import mechanisms\n"
        "model = sr.load(mechanisms.path('slider_crank'))\n"
        "print(sr.study(model, {'spring.k': [5, 10]}, 'slider.x', analysis=sr.Statics(), workers=2).success)\n"
    )
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=True)
    assert done.stdout == "[ True  True]\n"


@pytest.mark.slow
def test_functions_of_a_script_need_a_guard_and_say_so(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        "import sarrus as sr\n"
        "from sarrus import mechanisms\n"
        "def one(system): return {'k': 1.0}\n"
        "model = sr.load(mechanisms.path('slider_crank'))\n"
        "sr.study(model, {'spring.k': [5, 10]}, {'k': 'k'}, analysis=one, workers=2)\n"
    )
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert 'Put it under "if __name__ == "__main__":"' in done.stderr.splitlines()[-1]


def test_a_local_function_cannot_be_sent(model: Model) -> None:
    with pytest.raises(SarrusError, match=r"Define its functions at the top of a module, or take workers=1"):
        study(model, K, {"k": "k"}, analysis=lambda system: {"k": 1.0}, workers=2)


def test_the_table(model: Model, tmp_path: Path) -> None:
    found = study(model, {"spring.k": [5, 13, 20]}, {"k": "k"}, analysis=own.picky, sample=Grid(), workers=1)
    assert len(found) == 3
    assert found.best("k", largest=True) == [{"spring.k": 20.0, "k": 20.0}]
    assert found.statistics()["k"]["mean"] == 12.5
    assert found.to_array()["k"].tolist()[::2] == [5, 20]
    assert "1 failed: ZeroDivisionError: thirteen" in str(found)
    found.to_csv(tmp_path / "s.csv")
    rows = (tmp_path / "s.csv").read_text().splitlines()
    assert rows[0] == "case,spring.k,k,success,message,seconds"
    assert rows[2].startswith("1,13.0,nan,False,ZeroDivisionError: thirteen,")
    with pytest.raises(
        KeyError, match=r"no column 'l' in the study slider-crank. Its columns are spring.k, k"
    ):
        found["l"]
    axes = found.plot()
    assert [ax.get_xlabel() for ax in axes] == ["spring.k [N/m]", "k"]


def test_a_folder_without_a_study(tmp_path: Path) -> None:
    with pytest.raises(SarrusError, match=f"holds no study, for it has no readable {STUDY}"):
        open_study(tmp_path)


def test_times_that_are_products_are_those_of_the_run_itself(model: Model) -> None:
    """Not interpolated between two intervals of the histories."""
    coarse = Simulation(until=0.1, steps=2)
    product, number = (
        study(model, K, {"x": f"at(slider.x, {time})"}, analysis=coarse, workers=1)
        for time in ("0.3*0.1", "0.03")
    )
    assert np.array_equal(product["x"], number["x"])


def test_a_time_outside_that_a_parameter_gives_is_a_failure(model: Model) -> None:
    found = study(model, {"rod.mass": [0.05, 5.0]}, "at(slider.x, rod.mass)", analysis=SHORT, workers=1)
    assert 'holds "at(slider.x, rod.mass)", which has no real value there' in found.failures[1]
    assert found.success[0]
