"""Exported files where the disk is full: the error names the file, no part of it is left, and the shell says so."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from tests.workspace.mechanisms import arm_2r

import sarrus as sr
from sarrus import mechanisms

SMALL = 200  # bytes that a file may have


@contextmanager
def limited(size: int) -> Iterator[None]:
    """A limit of file sizes, which has the same effect as a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.fixture(scope="module")
def exports() -> dict[str, Callable[[Path], Any]]:
    """What writes a file, by the file's name."""
    system, output, limits = arm_2r()
    run = sr.simulate(sr.System(sr.load(mechanisms.path("slider_crank"))), until=0.01)
    area = sr.workspace(system, output, limits=limits, verify=False)
    field = sr.workspace_field(area, cells=8)
    return {
        "run.csv": run.to_csv, "run.parquet": run.to_parquet, "run.html": run.animate, "run.glb": run.animate,
        "run.gif": lambda file: run.animate(file, speed=0.1), "run.png": lambda file: sr.view(run.system.model, file),
        "area.csv": area.to_csv, "area.nc": area.to_netcdf, "field.csv": field.to_csv, "field.nc": field.to_netcdf,
    }  # fmt: skip


@pytest.mark.slow
def test_exports_to_a_full_disk(exports: dict[str, Callable[[Path], Any]], tmp_path: Path) -> None:
    for name, write in exports.items():
        file = tmp_path / name
        write(file)
        assert file.stat().st_size > SMALL, name
        keyword = {"path": file} if file.suffix in (".csv", ".nc") else {}
        with limited(SMALL), pytest.raises(OSError, match="cannot be written") as raised:
            write(**keyword) if keyword else write(file)
        assert str(file) in str(raised.value), name
        assert not file.exists(), name
        with pytest.raises(OSError, match=r"folder|directory"):
            write(tmp_path / "nowhere" / name)


LINES = [
    "run {model} --until 0.01 --csv {folder}/run.csv",
    "run {model} --until 0.01 --plot slider.x --figure {folder}/run.svg",
    "kinematics {driven} --until 0.01 --csv {folder}/motion.csv",
    "view {model} --output {folder}/page.html",
    "view {model} --output {folder}/page.png",
    "check {model} --draw {folder}/check.pdf",
]
SHELL = """
import resource, sys, matplotlib.font_manager
from sarrus.cli import main
sys.dont_write_bytecode = True
resource.setrlimit(resource.RLIMIT_FSIZE, (200, resource.RLIM_INFINITY))
for line in sys.stdin.read().splitlines():
    print(main(line.split()), flush=True)
"""


@pytest.mark.slow
def test_the_shell_on_a_full_disk(tmp_path: Path) -> None:
    """One message with the file for each line, and none of them is a defect."""
    model, driven = mechanisms.path("slider_crank"), tmp_path / "driven.yaml"
    driven.write_text(f"include: [{model}]\ndrivers: {{d: {{type: angle, joint: pin, motion: t}}}}\n")
    lines = "\n".join(line.format(model=model, driven=driven, folder=tmp_path) for line in LINES)
    done = subprocess.run(
        [sys.executable, "-c", SHELL],
        input=lines,
        capture_output=True,
        text=True,
        check=False,
        env=dict(os.environ),
    )
    codes = [line for line in done.stdout.splitlines() if line in ("0", "1", "2", "3")]
    assert codes == ["2"] * len(LINES), done.stdout + done.stderr
    assert "defect" not in done.stderr
    assert "Traceback" not in done.stderr
    for line in lines.splitlines():
        file = line.split()[-1]
        assert f"{file}: cannot be written (File too large). Raise the limit" in done.stderr
        assert not Path(file).exists()


def test_a_table_of_some_outputs_is_the_file_that_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not a file that has the name of an output by chance."""
    run = sr.simulate(sr.System(sr.load(mechanisms.path("slider_crank"))), until=0.01)
    monkeypatch.chdir(tmp_path)
    Path("slider.x").write_text("mine")
    with limited(SMALL), pytest.raises(OSError, match=r"run\.csv: cannot be written"):
        run.to_csv("run.csv", "slider.y", "slider.x")
    assert not Path("run.csv").exists()
    assert Path("slider.x").read_text() == "mine"
    with pytest.raises(OSError, match=r"x\.csv: cannot be written .* Make its folder"):
        run.to_csv("nowhere/x.csv", "slider.x")
    with pytest.raises(TypeError, match="path"):
        run.to_csv()
