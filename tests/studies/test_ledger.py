"""The folder of a study cannot be lost or lie: other data, other writers, damaged lines, crashes and full disks."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.analyses.test_saved_folders import ROOT, contents, disk, writer
from tests.studies import own

import sarrus as sr
from sarrus.model import Model, SarrusError
from sarrus.results.saving import checked_file
from sarrus.studies import open_study, study
from sarrus.studies.ledger import CASES, STUDY

__all__ = ["disk"]  # a fixture
K = [float(k) for k in range(5, 15)]


def run(model: Model, folder: Path, **changes: Any) -> sr.StudyTable:
    asked: dict[str, Any] = {"analysis": own.quick, "workers": 1, "folder": folder} | changes
    return study(model, {"spring.k": asked.pop("k", K)}, {"k": "k"}, **asked)


def lines_of(folder: Path) -> list[bytes]:
    return (folder / CASES).read_bytes().splitlines(keepends=True)


# ---------------------------------------------------------------------------------------------- other data
@pytest.mark.parametrize(
    "names", [("notes.txt",), (CASES,), ("lock", CASES), ("model/slider_crank.yaml",), (STUDY,)]
)
def test_what_is_no_study_is_never_touched(model: Model, names: tuple[str, ...], tmp_path: Path) -> None:
    folder = tmp_path / "thesis"
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text('{"mine": 1}\n')
    before = contents(folder)
    with pytest.raises(SarrusError, match=r"holds other files and no study|in format None"):
        run(model, folder)
    assert contents(folder) == before


def test_a_file_is_no_folder(model: Model, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    for folder in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(SarrusError, match="is a file, not a folder"):
            run(model, folder)


# ------------------------------------------------------------------------------------------- other writers
WRITER = """
import sys, time, sarrus as sr
from pathlib import Path
from tests.studies import test_ledger as here
def wait(done):
    print("writing", flush=True)
    time.sleep(100)
model = sr.load(sr.mechanisms.path("slider_crank"))
here.run(model, Path(sys.argv[1]), progress=wait)
"""


def test_a_second_writer_is_refused_and_a_dead_one_is_replaced(model: Model, tmp_path: Path) -> None:
    folder = tmp_path / "s"
    first = writer(WRITER, folder)
    try:
        with pytest.raises(
            SarrusError, match=f"s: is being written by process {first.pid} on .*. Wait until it ends"
        ):
            run(model, folder)
        with pytest.warns(sr.SarrusWarning, match="cases are done"):
            assert open_study(folder).success.sum() == 1
    finally:
        first.kill()
        first.communicate()
    assert run(model, folder)["k"].tolist() == K


# -------------------------------------------------------------------------------------------------- damage
def flip(lines: list[bytes]) -> None:
    lines[3] = lines[3].replace(b"8.0", b"9.0")


def lose(lines: list[bytes]) -> None:
    del lines[3]


def swap(lines: list[bytes]) -> None:
    lines[3], lines[4] = lines[4], lines[3]


def double(lines: list[bytes]) -> None:
    lines.insert(3, lines[2])


def cut(lines: list[bytes]) -> None:
    lines[3] = lines[3][:30] + b"\n"


def zero(lines: list[bytes]) -> None:
    lines[3] = bytes(len(lines[3]) - 1) + b"\n"


def borrow(lines: list[bytes]) -> None:
    """A line with its own checksum, as of another study."""
    entry = json.loads(lines[3])
    entry.pop("checksum")
    text = json.dumps(entry | {"responses": [7.0]})
    own = checked_file.checksum(text.encode()).hex()
    lines[3] = f'{text[:-1]}, "checksum": "{own}"}}\n'.encode()


@pytest.mark.one_in(8)
@pytest.mark.parametrize("change", [flip, lose, swap, double, cut, zero, borrow])
def test_a_damaged_line_is_refused_with_its_number(
    model: Model, change: Callable[[list[bytes]], None], tmp_path: Path
) -> None:
    """Until it and all below it are deleted, as the message says; then their cases are run again."""
    run(model, tmp_path)
    lines = lines_of(tmp_path)
    change(lines)
    (tmp_path / CASES).write_bytes(b"".join(lines))
    for use in (lambda: open_study(tmp_path), lambda: run(model, tmp_path)):
        with pytest.raises(SarrusError, match=r"cases.jsonl:4: is damaged: its checksum is wrong. Restore"):
            use()
    (tmp_path / CASES).write_bytes(b"".join(lines[:3]))
    done: list[int] = []
    assert run(model, tmp_path, progress=done.append)["k"].tolist() == K
    assert done == [*range(4, 11)]


def test_blank_lines_are_harmless_and_a_torn_one_is_run_again(model: Model, tmp_path: Path) -> None:
    run(model, tmp_path)
    lines = lines_of(tmp_path)
    torn = [b"\n", *lines[:4], b"\r\n", b"  \n", *lines[4:9], lines[9][:-5]]
    (tmp_path / CASES).write_bytes(b"".join(torn))
    with pytest.warns(sr.SarrusWarning, match="9 of 10 cases are done, and statistics are of these alone"):
        part = open_study(tmp_path)
    assert part["k"].tolist() == pytest.approx([*K[:9], np.nan], nan_ok=True)
    assert part.status == "unfinished"
    assert "10 cases, 1 not run" in str(part)
    assert "9 of 10 cases are done" in str(part)
    done: list[int] = []
    assert run(model, tmp_path, progress=done.append)["k"].tolist() == K
    assert done == [10]
    whole = open_study(tmp_path)
    assert (whole["k"].tolist(), whole.status, whole.warnings) == (K, "finished", ())


@pytest.mark.one_in(8)
@pytest.mark.parametrize("text", ["", "{}", "[1, 2]", "3", '{"name": ', "\0" * 50])
def test_a_damaged_description_is_refused(model: Model, text: str, tmp_path: Path) -> None:
    run(model, tmp_path)
    (tmp_path / STUDY).write_text(text)
    for use in (lambda: open_study(tmp_path), lambda: run(model, tmp_path)):
        with pytest.raises(SarrusError, match=r"study.json: is damaged|study.json: is in format None"):
            use()


def test_a_changed_description_and_another_format_are_refused(model: Model, tmp_path: Path) -> None:
    run(model, tmp_path)
    text = (tmp_path / STUDY).read_text()
    for old, new, told in (
        ("5.0", "5.5", "study.json: is damaged"),
        (
            '"format": 2',
            '"format": 999',
            "study.json: is in format 999, and this version of Sarrus reads format 2",
        ),
    ):
        assert old in text
        (tmp_path / STUDY).write_text(text.replace(old, new, 1))
        with pytest.raises(SarrusError, match=told):
            open_study(tmp_path)
    (tmp_path / STUDY).write_text(text)
    (tmp_path / CASES).unlink()
    with pytest.raises(SarrusError, match=r"cases.jsonl: is missing. Restore it"):
        open_study(tmp_path)


# ----------------------------------------------------------------------------------------- crashes, full disks
def test_a_study_that_crashed_before_its_first_line_begins_again(
    model: Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def crash(path: Path, data: bytes) -> None:
        path.with_name(path.name + checked_file.DRAFT).write_bytes(data[:10])
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("sarrus.studies.ledger.replace_file", crash)
        with pytest.raises(KeyboardInterrupt):
            run(model, tmp_path / "s")
    assert run(model, tmp_path / "s")["k"].tolist() == K


LIMITED = """
import resource, sys, warnings, sarrus as sr
from pathlib import Path
from tests.studies import test_ledger as here
model = sr.load(sr.mechanisms.path("slider_crank"))
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), resource.RLIM_INFINITY))
warnings.simplefilter("ignore")
made = here.run(model, Path(sys.argv[1]), k=list(range(100)), workers=int(sys.argv[3]))
print(made.status, int(made.success.sum()))
print(made.warnings[0])
"""


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_a_limit_of_file_sizes_ends_in_a_table(model: Model, workers: int, tmp_path: Path) -> None:
    folder, k = tmp_path / "s", [*range(100)]
    command = [sys.executable, "-c", LIMITED, str(folder), "9000", str(workers)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    told, message = done.stdout.splitlines()
    status, count = told.rsplit(" ", 1)
    assert status == "not saved"
    assert 0 < int(count) < 100
    assert "(File too large). Raise the limit of file sizes" in message
    assert "the same call continues" in message
    saved = open_study(folder)
    assert 0 < saved.success.sum() <= int(count)
    assert run(model, folder, k=k)["k"].tolist() == k


def test_a_full_disk_and_a_folder_that_cannot_be_written_end_in_a_table(model: Model, disk: Path) -> None:
    ballast, folder = disk / "ballast", disk / "s"
    with suppress(OSError), ballast.open("wb", buffering=0) as file:
        while file.write(bytes(4096)):
            pass
    with pytest.warns(sr.SarrusWarning, match=r"No space left on device\). Free disk space"):
        table = run(model, folder)
    assert table.status == "not saved"
    ballast.unlink()
    assert run(model, folder, k=K)["k"].tolist() == K
    subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
    for place in (folder, disk / "other"):
        with pytest.warns(sr.SarrusWarning, match=r"Read-only file system\). Make it writable"):
            assert run(model, place).status == "not saved"
    assert open_study(folder)["k"].tolist() == K


def test_lines_are_flushed_to_the_disk(model: Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    flushed = list[str]()
    fsync = os.fsync

    def note(number: int) -> None:
        flushed.append(Path(f"/proc/self/fd/{number}").readlink().name)
        fsync(number)

    monkeypatch.setattr(os, "fsync", note)
    run(model, tmp_path)
    assert {STUDY + checked_file.DRAFT, CASES} <= set(flushed)
    assert flushed[-1] == CASES
