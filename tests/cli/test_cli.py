"""The command line, called as a user calls it."""

import json
import re
import signal
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from tests.patience import within_by_the_clock

import sarrus as sr
from sarrus import mechanisms
from sarrus.analyses.integration_methods import METHODS, method_named
from sarrus.cli import VERBS, main
from sarrus.cli.verbs import demo

SLIDER_CRANK = str(mechanisms.path("slider_crank"))


def test_demo(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("SARRUS_PROGRESS", raising=False)
    assert main(["demo", "--output", str(tmp_path)]) == 0
    told = capsys.readouterr()
    assert "operators checked, all agree" in told.out
    assert "final of slider.x = 4.749343" in told.out  # by an independent program 4.749343770
    rows = [line.split() for line in told.out.splitlines() if re.search(r"[+-][\d.e-]+ m$", line)]
    assert [row[0] for row in rows] == [
        "spring.length",
        "cross.point.x",
        "gravity.z",
        "crank.position.z",
        "pin.point.y",
    ]
    assert rows[2][2::2] == ["m/s²", "s²", "m"]
    assert "slider.x can be from 3.65282709 to 4.96556686 m. Ends: 3.65282709 by singularity" in told.out
    assert re.search(r"compiling kernels .*\.\.\.\n.*: done in", told.err)
    page = tmp_path / "slider_crank.html"
    assert [*tmp_path.iterdir()] == [page]
    assert page.stat().st_size < 1_500_000
    assert page.resolve().as_uri() in told.out.splitlines()[-1]


def test_the_first_demo_compiles_in_two_processes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The other one is `sarrus compile`, and ends with the demo, also by Ctrl-C."""
    begun: list[subprocess.Popen[bytes]] = []

    class Noted(subprocess.Popen[bytes]):
        def __init__(self, command: list[str], **settings: Any) -> None:
            super().__init__(command, **settings)
            begun.append(self)

    monkeypatch.setattr("subprocess.Popen", Noted)
    monkeypatch.setattr("sarrus._jit.linking.cache.folder", lambda: tmp_path)
    monkeypatch.setattr("sarrus._jit.linking.shipped.shipped", lambda: None)
    monkeypatch.setattr("sarrus.studies.pool.available", lambda: 2)
    with within_by_the_clock(60), pytest.raises(KeyboardInterrupt), demo._compiled_beside():
        raise KeyboardInterrupt
    assert begun[0].args[-3:] == ["sarrus", "compile", "slider_crank"]
    assert begun[0].returncode == -signal.SIGKILL
    monkeypatch.setattr("sarrus.studies.pool.available", lambda: 1)
    with demo._compiled_beside():
        pass
    monkeypatch.setattr("sarrus.studies.pool.available", lambda: 2)
    (tmp_path / "Phi_q.1.kernel").touch()
    with demo._compiled_beside():
        pass
    assert len(begun) == 1


def test_check(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", SLIDER_CRANK, "--operators"]) == 0
    told = capsys.readouterr().out
    assert "((Φ_q ξ)_q η)_q" in told
    assert "slider-crank: 1 degree of freedom" in told
    assert main(["check", SLIDER_CRANK]) == 0
    short = capsys.readouterr().out
    assert short.splitlines()[-1] == told.splitlines()[-1]
    assert len(short.splitlines()) < len(told.splitlines()) - 40


def test_check_tells_and_draws_the_model_first(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", SLIDER_CRANK, "--draw", str(tmp_path / "crank.png")]) == 0
    assert capsys.readouterr().out.startswith("slider-crank, from")
    assert (tmp_path / "crank.png").stat().st_size > 10_000


@pytest.mark.parametrize("rtol", ["1e-6", "0.1"])
def test_run_verifies_its_digits(rtol: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A run that agrees with a finer one ends with 0; another with 1, and names what differs."""
    arguments = ["run", SLIDER_CRANK, "--until", "0.5", "--steps", "5", "--rtol", rtol, "--verify", "--json"]
    code = main(arguments)
    told = json.loads(capsys.readouterr().out)["verification"]
    system = sr.System(sr.load("slider_crank"))
    run = sr.simulate(
        system, until=0.5, t_eval=[0, 0.1, 0.2, 0.3, 0.4, 0.5], method=sr.Radau(rtol=float(rtol))
    )
    found = sr.verify(run)
    assert (code, told["agree"], told["message"]) == (int(not found.agree), found.agree, found.message)
    assert code == (rtol == "0.1")
    assert [one["name"] for one in told["values"]] == [one.name for one in found.values]
    assert [one["value"] for one in told["values"]] == pytest.approx([one.value for one in found.values])


def test_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table, figure = tmp_path / "run.csv", tmp_path / "run.svg"
    arguments = [
        "--until",
        "0.5",
        "--steps",
        "10",
        "--csv",
        str(table),
        "--plot",
        "slider.x",
        "--figure",
        str(figure),
    ]
    assert main(["run", SLIDER_CRANK, *arguments]) == 0
    assert "slider" in capsys.readouterr().out
    assert len(table.read_text().splitlines()) == 12
    assert figure.exists()


def test_view(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = tmp_path / "crank.html"
    assert main(["view", SLIDER_CRANK, "--assemble", "--output", str(page)]) == 0
    assert "slider-crank" in page.read_text()
    assert f"wrote {page}" in capsys.readouterr().err


def test_view_of_a_motion(tmp_path: Path) -> None:
    page = tmp_path / "crank.html"
    assert (
        main(
            [
                "view",
                SLIDER_CRANK,
                "--until",
                "0.2",
                "--trace",
                "rod",
                "--plot",
                "spring.tension",
                "--output",
                str(page),
            ]
        )
        == 0
    )
    assert '"curves":[{"name":"spring.tension","unit":"N"' in page.read_text()
    assert '"traces":[{"body":2' in page.read_text()


def test_schema(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema"]) == 0
    assert json.loads(capsys.readouterr().out)["$schema"].startswith("https://json-schema.org")


def test_a_wrong_model_gives_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wrong = tmp_path / "wrong.yaml"
    wrong.write_text("name: wrong\nbodies:\n  rod: {mass: -1, inertia: [1, 1, 1]}\n")
    for verb in ("check", "run"):
        assert main([verb, str(wrong)]) == 2
        told = capsys.readouterr().err
        assert told.startswith(f"sarrus: {wrong}:3")
        assert told.count("\n") == 1


MISUSE = [
    ("run {} --until -1", "--until: must be a positive finite number, but is -1"),
    ("run {} --until inf", "--until: must be a positive finite number, but is inf"),
    ("run {} --rtol nan", "--rtol: must be a positive finite number, but is nan"),
    ("run {} --rtol -1", "--rtol: must be a positive finite number, but is -1"),
    ("run {} --steps 1000000000000", "--steps: must be a whole number from 1 to 1000000"),
    ("run {} --plot slider.x --figure a.xyz", "--figure: must end in .png, .svg or .pdf, but is a.xyz"),
    ("run {} --plot slider.w", "slider-crank has no output 'slider.w'. Did you mean"),
    ("run {} --csv none/a.csv", "there is no folder none. Make it first"),
    ("run {} --csv .", "is a folder. Name a file in it"),
    ("check {} --seed -1", "--seed: must be a whole number of at least 0, but is -1"),
    ("run none.yaml", "none.yaml: does not exist. Check the path"),
    ("walk", "there is no verb 'walk'. Choose from check"),
    ("view {} --output x.doc", "must end in .html, .glb, .png, .gif or .mp4, but is x.doc"),
    (
        f"view {SLIDER_CRANK} --output x.gif",
        "x.gif: a film needs a motion. Give its duration with --until",
    ),
    ("view {} --until 1 --trace rope", 'no body "rope" in slider-crank'),
    ("view {} --until 1 --plot slider.w", "slider-crank has no output 'slider.w'. Did you mean"),
    ("view {} --plot slider.x", "--plot needs a motion. Give its duration with --until."),
    ("view {} --trace slider", "--trace needs a motion. Give its duration with --until."),
    ("demo --output {}", "is a file, not a folder. Choose another --output"),
]


@pytest.mark.parametrize(("line", "sentence"), MISUSE, ids=[line for line, _ in MISUSE])
def test_misuse_gives_one_sentence(line: str, sentence: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([word.format(SLIDER_CRANK) for word in line.split()]) == 2
    told = capsys.readouterr()
    assert sentence in told.err
    assert told.err.startswith("sarrus: ")
    assert told.err.count("\n") == 1
    assert not told.out


def test_an_unexpected_error_is_one_sentence_and_with_debug_a_traceback(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def trouble(*args: object, **options: object) -> None:
        raise ValueError("matrix of odd size")

    monkeypatch.setattr("sarrus.analyses.position.initial_state.start_of", trouble)
    assert main(["run", SLIDER_CRANK]) == 2
    assert capsys.readouterr().err == "sarrus: matrix of odd size (--debug shows where)\n"
    assert main(["run", SLIDER_CRANK, "--debug"]) == 2
    assert "Traceback" in capsys.readouterr().err


@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", METHODS)
def test_methods(method: str, capsys: pytest.CaptureFixture[str]) -> None:
    line = ["run", "slider_crank", "--until", "0.2", "--rtol", "1e-6", "--atol", "1e-8", "--method", method]
    assert main([*line, "--json", "-q"]) == 0
    found = json.loads(capsys.readouterr().out)
    system = sr.System(sr.load(mechanisms.path("slider_crank")))
    wanted = sr.simulate(system, until=0.2, method=replace(method_named(method)(), rtol=1e-6, atol=1e-8))
    assert found["nsteps"] == wanted.nsteps
    assert found["bodies"]["slider"]["position"] == pytest.approx(wanted["slider"].position[-1])


def test_a_run_that_fails_at_the_start_still_says_why(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from sarrus.analyses.dynamics.time_loop.outcome import nothing

    monkeypatch.setattr(
        "sarrus.analyses.simulate", lambda system, *args, **options: nothing(system, "stopped", "it is stuck")
    )
    assert main(["run", SLIDER_CRANK]) == 1
    assert "slider-crank: it is stuck; 0 steps" in capsys.readouterr().out


@pytest.mark.parametrize("verb", VERBS)
def test_help(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main([verb, "--help"])
    assert left.value.code == 0
    assert verb in capsys.readouterr().out


def test_statics(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["statics", SLIDER_CRANK]) == 0
    told = capsys.readouterr().out
    assert "it is stable, the smallest frequency is 0.407188 Hz" in told
    assert "guide" in told


def test_statics_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["statics", SLIDER_CRANK, "--nearest"]) == 0
    assert "unstable along 1 motion" in capsys.readouterr().out


def test_modes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    figure = tmp_path / "modes.svg"
    assert main(["modes", str(mechanisms.path("hmmwv")), "--figure", str(figure)]) == 0
    told = capsys.readouterr().out
    assert "this equilibrium is marginal, with 3 free motions" in told
    assert "chassis" in told
    assert figure.exists()


def test_kinematics_without_drivers(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["kinematics", SLIDER_CRANK]) == 1
    assert "keeps 1 degree of freedom" in capsys.readouterr().out


def test_kinematics_of_unknown_joint(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["kinematics", SLIDER_CRANK, "--reaction", "pim"]) == 2
    assert "no joint or driver 'pim'" in capsys.readouterr().err


def test_kinematics(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    driven, figure, table = tmp_path / "driven.yaml", tmp_path / "motor.svg", tmp_path / "run.csv"
    text = Path(SLIDER_CRANK).read_text()
    driven.write_text(text + "\ndrivers:\n  motor: {type: angle, joint: pin, motion: 3*t}\n")
    wanted = ["--steps", "20", "--reaction", "motor", "--figure", str(figure), "--csv", str(table)]
    assert main(["kinematics", str(driven), *wanted]) == 0
    told = capsys.readouterr().out
    assert "reached the end" in told
    assert "motor" in told
    assert "force up to" in told
    assert figure.exists()
    assert len(table.read_text().splitlines()) == 22


def test_json_of_a_run_holds_what_people_read(capsys: pytest.CaptureFixture[str]) -> None:
    main(["run", SLIDER_CRANK, "--until", "0.1", "--json"])
    found = json.loads(capsys.readouterr().out)
    main(["run", SLIDER_CRANK, "--until", "0.1"])
    assert f"x = {found['bodies']['slider']['position'][0]:+.9f}" in capsys.readouterr().out


def test_json_of_an_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "none.yaml", "--json"]) == 2
    told = capsys.readouterr()
    assert json.loads(told.out)["error"] in told.err


def test_what_json_lacks_is_null() -> None:
    import numpy as np

    from sarrus.cli.answer import plain

    found = plain({"x": np.array([1.0, np.nan]), "z": 1 + 2j, "path": Path("a"), "ok": np.True_})
    assert found == {"x": [1.0, None], "z": [1.0, 2.0], "path": "a", "ok": True}


def test_a_defect_is_one_sentence_too(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sarrus.analyses.position.initial_state.start_of", lambda system: system.nonsense)
    assert main(["run", SLIDER_CRANK]) == 3
    told = capsys.readouterr().err
    assert "This is a defect of Sarrus" in told
    assert "Traceback" not in told


def test_levels_of_notes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = ["run", SLIDER_CRANK, "--until", "0.1", "--csv", str(tmp_path / "run.csv")]
    told = []
    for extra in (["-q"], [], ["-v"]):
        main([*line, *extra])
        told.append(capsys.readouterr().err)
    assert told[0] == ""
    assert "wrote" in told[1]
    assert "run took" not in told[1]
    assert "run took" in told[2]


def test_colours_only_on_terminals(monkeypatch: pytest.MonkeyPatch) -> None:
    from io import StringIO

    from sarrus.cli.terminal import painted

    class Terminal(StringIO):
        def isatty(self) -> bool:
            return True

    for name in ("NO_COLOR", "FORCE_COLOR", "TERM"):
        monkeypatch.delenv(name, raising=False)
    assert painted("no", "red", StringIO()) == "no"
    assert painted("no", "red", Terminal()) == "\033[31mno\033[0m"
    monkeypatch.setenv("NO_COLOR", "1")
    assert painted("no", "red", Terminal()) == "no"


@pytest.mark.parametrize("verb", VERBS)
def test_help_has_examples_that_parse(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    import shlex

    from sarrus.cli.parser import build

    for line in VERBS[verb].EXAMPLES:
        words = shlex.split(line.removeprefix('eval "$(').replace(')"', ""), comments=True)
        words = words[: words.index(">")] if ">" in words else words
        assert build([verb]).parse_args(words[1:]).verb == verb


def test_bash_completes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import shutil
    import subprocess

    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("there is no bash")
    main(["completion", "bash"])
    script = capsys.readouterr().out

    (tmp_path / "crank.yaml").touch()

    def completed(*words: str) -> list[str]:
        """What the function that the script registers for ``sarrus`` answers, called as the shell calls it."""
        line = " ".join(f"'{word}'" for word in words)
        ask = f"""
            function=$(complete -p sarrus | sed 's/.*-F \\([^ ]*\\).*/\\1/')
            COMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; "$function" sarrus '{words[-1]}' '{words[-2]}'
            printf '%s\\n' "${{COMPREPLY[@]}}"
        """
        call = [bash, "-c", script + ask]
        return subprocess.run(call, capture_output=True, text=True, check=True, cwd=tmp_path).stdout.split()

    assert completed("sarrus", "ki") == ["kinematics"]
    assert completed("sarrus", "run", "--un") == ["--until"]
    assert completed("sarrus", "run", "--base", "") == ["file", "fixed", "floating"]
    assert completed("sarrus", "run", "cra") == ["crank.yaml"]
    assert completed("sarrus", "completion", "") == ["bash", "zsh", "fish", "tcsh", "powershell"]


def test_zsh_and_fish_know_every_option(capsys: pytest.CaptureFixture[str]) -> None:
    main(["completion", "zsh"])
    assert r'"--until[end time \[s\], or with a unit\: 500 ms (1)]:until:_files"' in capsys.readouterr().out
    main(["completion", "fish"])
    told = capsys.readouterr().out
    assert re.search(r"using run' -l until -x.* -d 'end time \[s\], or with a unit: 500 ms \(1\)'", told)
    assert '-l base -xka "file fixed floating"' in told
