"""Exported files where the disk is full: the error names the file, the earlier one stays, and the shell says so."""

from __future__ import annotations

import errno
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
from sarrus.views.browser.page import Page

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
        "run.xml": lambda file: sr.export(run.system.model, file),
        "area.csv": area.to_csv, "area.nc": area.to_netcdf, "field.csv": field.to_csv, "field.nc": field.to_netcdf,
    }  # fmt: skip


@pytest.mark.slow
def test_exports_to_a_full_disk(exports: dict[str, Callable[[Path], Any]], tmp_path: Path) -> None:
    for name, write in exports.items():
        file = tmp_path / name
        write(file)
        assert file.stat().st_size > SMALL, name
        before, folder = file.read_bytes(), sorted(tmp_path.iterdir())
        keyword = {"path": file} if file.suffix in (".csv", ".nc") else {}
        with limited(SMALL), pytest.raises(OSError, match="cannot be written") as raised:
            write(**keyword) if keyword else write(file)
        assert str(file) in str(raised.value), name
        assert file.read_bytes() == before, name
        assert sorted(tmp_path.iterdir()) == folder
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
    Path("run.csv").write_text("earlier")
    with limited(SMALL), pytest.raises(OSError, match=r"run\.csv: cannot be written"):
        run.to_csv("run.csv", "slider.y", "slider.x")
    assert Path("run.csv").read_text() == "earlier"
    assert sorted(os.listdir()) == ["run.csv", "slider.x"]
    assert Path("slider.x").read_text() == "mine"
    with pytest.raises(OSError, match=r"x\.csv: cannot be written .* Make its folder"):
        run.to_csv("nowhere/x.csv", "slider.x")
    with pytest.raises(TypeError, match="path"):
        run.to_csv()


def test_replaced_files_keep_links_permissions_and_what_may_not_be_written(tmp_path: Path) -> None:
    page, data, link = Page("t", "new"), tmp_path / "data", tmp_path / "page.html"
    data.mkdir()
    real = data / "real.html"
    real.write_text("old")
    real.chmod(0o600)
    link.symlink_to(real)
    page.save(link)
    assert link.is_symlink()
    assert real.read_text() == "new"
    assert real.stat().st_mode & 0o777 == 0o600
    page.save("/dev/null")
    assert not Path("/dev/null").is_file()
    if os.geteuid():  # the superuser may write all files
        real.chmod(0o400)
        with pytest.raises(OSError, match=r"page\.html: cannot be written .* Make it writable"):
            page.save(link)
    assert [*data.iterdir()] == [real]


def test_a_model_is_exported_with_its_loops_or_not_at_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, other = (sr.Body(name, mass=1, inertia=(1, 1, 1)) for name in "ab")
    pins = {"p": (sr.ground, one, 0), "q": (one, other, 1), "r": (sr.ground, other, 2)}
    joints = [sr.Revolute(name, i, j, point=(x, 0, 0), axis=(0, 0, 1)) for name, (i, j, x) in pins.items()]
    bars = sr.Model("bars", [one, other], joints)
    file, loops = tmp_path / "crank.urdf", tmp_path / "crank.loops.yaml"
    for place in (file, loops):
        place.write_text("earlier")
    write = Path.write_text

    def full(place: Path, text: str, **options: Any) -> int:
        if place.suffix == ".yaml":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(place, text, **options)

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(OSError, match=r"crank\.loops\.yaml: cannot be written .* Free disk space"):
        sr.export(bars, file)
    assert [place.read_text() for place in (file, loops)] == ["earlier"] * 2
    assert len([*tmp_path.iterdir()]) == 2
