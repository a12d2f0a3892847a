"""Consoles that lack characters, and streams that are missing, closed or full: all that can be written is written."""

from __future__ import annotations

import os
import subprocess
import sys
from io import BytesIO, TextIOWrapper
from pathlib import Path

import pytest

import sarrus as sr
from sarrus._jit.linking.compilation import draw
from sarrus.console import printable

MODEL = Path(__file__).parents[1] / "src" / "sarrus" / "mechanisms" / "slider_crank.yaml"
SHORT = """
import sarrus as sr
print(sr.simulate(sr.System(sr.load("slider_crank")), until=0.01, progress=True))
"""


class Latin:
    """A stream of another encoding."""

    def __init__(self, encoding: str) -> None:
        self.encoding = encoding


@pytest.mark.parametrize(
    ("encoding", "expected"),
    [
        ("ascii", "|Phi_qT lambda| <= 2 +- 0.5 kg m2, 90deg, x, ..."),
        ("cp437", "|Φ_qT lambda| ≤ 2 ± 0.5 kg m², 90°, x, ..."),
        ("cp1252", "|Phi_qT lambda| <= 2 ± 0.5 kg m², 90°, x, …"),
        ("utf-8", "|Φ_qᵀ λ| ≤ 2 ± 0.5 kg m², 90°, ẋ, …"),
    ],
)
def test_characters_that_a_console_lacks_are_written_in_ascii(encoding: str, expected: str) -> None:
    assert printable("|Φ_qᵀ λ| ≤ 2 ± 0.5 kg m², 90°, ẋ, …", Latin(encoding)) == expected


@pytest.mark.parametrize("encoding", ["ascii", "cp437", "cp1252"])
def test_results_are_printed_in_characters_of_the_console(
    encoding: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    written = [BytesIO(), BytesIO()]
    for name, stream in zip(("stdout", "stderr"), written, strict=True):
        monkeypatch.setattr(sys, name, TextIOWrapper(stream, encoding=encoding, write_through=True))
    model = sr.load("slider_crank")
    system = sr.System(model)
    run = sr.simulate(system, until=0.01, store="steps", progress=True)
    gradient = sr.sensitivity(run, sr.Final("slider.x"), ["spring.k"])
    start = sr.assemble(system)
    for shown in (
        run,
        start,
        sr.describe(model),
        model,
        system,
        gradient,
        gradient.table(),
        run.error("slider.x"),
    ):
        print(shown)
        print(repr(shown))
    out, err = (stream.getvalue().decode(encoding) for stream in written)
    assert ("|Φ| <" if encoding == "cp437" else "|Phi| <") in out
    assert "?" not in out
    assert "simulated" in err


@pytest.mark.parametrize("missing", [None, "closed"])
def test_progress_is_left_out_without_standard_error(
    missing: str | None, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    stream = TextIOWrapper(BytesIO()) if missing else None
    if stream:
        stream.close()
    monkeypatch.setattr(sys, "stderr", stream)
    draw("compiling")
    assert sr.simulate(sr.System(sr.load("slider_crank")), until=0.01, progress=True).success
    assert not capsys.readouterr().out


def done(
    words: list[str], encoding: str = "utf-8", redirection: str = ""
) -> subprocess.CompletedProcess[bytes]:
    """Run Python in a shell with redirections of its streams."""
    command = ["bash", "-c", f'exec "$@" {redirection}', "bash", sys.executable, *words]
    environment = {**os.environ, "PYTHONIOENCODING": encoding}
    return subprocess.run(command, capture_output=True, check=False, timeout=300, env=environment)


VERBS = {
    "check": [],
    "run": ["--until", "0.01"],
    "sensitivity": ["--until", "0.01", "--response", "slider.x"],
}


@pytest.mark.slow
@pytest.mark.parametrize("verb", [*VERBS])
def test_verbs_write_in_characters_of_the_console(verb: str) -> None:
    found = done(["-m", "sarrus", verb, str(MODEL), *VERBS[verb]], "cp1252")
    assert not found.returncode, found.stderr
    assert b"?" not in found.stdout
    assert found.stdout.decode("cp1252")


@pytest.mark.slow
@pytest.mark.parametrize("redirection", ["2>&-", ">&-", ">&- 2>&-"])
def test_streams_that_are_closed(redirection: str, tmp_path: Path) -> None:
    """In the library and in the shell; what is for one stream does not enter the other, nor a file."""
    csv = tmp_path / "run.csv"
    found = done(
        ["-m", "sarrus", "run", str(MODEL), "--until", "0.01", "--csv", str(csv)], "utf-8", redirection
    )
    assert not found.returncode, found.stderr
    assert csv.read_text().startswith("t [s]")
    assert b"Traceback" not in found.stderr
    assert b"wrote" not in found.stdout
    found = done(["-c", SHORT], "utf-8", redirection)
    assert not found.returncode, found.stderr
    assert b"simulated" not in found.stdout


@pytest.mark.slow
@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="Linux only")
def test_a_full_output_is_one_message() -> None:
    for more in (["--json"], []):
        found = done(["-m", "sarrus", "run", str(MODEL), "--until", "0.01", *more], "utf-8", ">/dev/full")
        assert found.returncode == 2
        assert b"no space left on device" in found.stderr.lower()
        assert b"Traceback" not in found.stderr
        assert b"Exception ignored" not in found.stderr
