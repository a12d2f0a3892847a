"""The benchmark that tries files of folders: what it reports of files that run, differ in kind, or are refused."""

import hashlib
import subprocess
import time
from functools import partial
from pathlib import Path

import pytest

pytest.importorskip("mujoco")

from benchmarks import corpora
from benchmarks.corpora import Worker, files, tried, write_hashes
from benchmarks.trees import time_at

pytestmark = pytest.mark.needs("mujoco")

BODY = '<body name="{0}"><joint name="j{0}" axis="1 2 3" damping="0.1"/><geom type="box" size="0.1 0.2 0.3"/>{1}</body>'
MOTOR = '<actuator><dcmotor joint="ja" motorconst="2" resistance="1"/></actuator>'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    tree = f"<mujoco>{{}}<worldbody>{BODY.format('a', BODY.format('b', ''))}</worldbody></mujoco>"
    (tmp_path / "runs.xml").write_text(tree.format(""))
    (tmp_path / "motor.xml").write_text(tree.format(MOTOR))
    (tmp_path / "renamed.xml").write_text(
        tree.format("").replace('name="a"', 'name="1 a"').replace('"b"', '"1:b"')
    )
    (tmp_path / "cut.xml").write_text(tree.format("")[:-9])
    (tmp_path / "broken.xml").write_text(tree.format("<nothing/>"))
    (tmp_path / "part.xml").write_text("<mujoco><default/></mujoco>")
    return tmp_path


def test_files_are_counted_by_what_happens_to_them(folder: Path) -> None:
    rows = {path.name: [*tried(path, kind, [], 0.001)][-1] for path, kind in files([folder])}
    assert {name: row["result"] for name, row in rows.items()} == {
        "runs.xml": "ran",
        "renamed.xml": "ran",
        "motor.xml": "refused",
        "broken.xml": "unreadable",
        "cut.xml": "unreadable",
    }
    assert rows["runs.xml"]["difference"] < 1e-10
    assert rows["renamed.xml"]["difference"] == pytest.approx(rows["runs.xml"]["difference"])
    assert rows["motor.xml"]["reason"].endswith("ignore=['actuators']")


def test_dry_friction_of_a_free_body_is_not_compared(tmp_path: Path) -> None:
    """MuJoCo's is elastic."""
    body = '<body><joint type="free" frictionloss="5" damping="0.1"/><geom type="box" size="0.1 0.2 0.3"/></body>'
    (tmp_path / "free.xml").write_text(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
    assert [*tried(tmp_path / "free.xml", "MJCF", [], 0.001)][-1]["difference"] < 1e-10


def test_the_process_that_tries_files_is_replaced_when_it_ends(folder: Path) -> None:
    worker = Worker([], 0.001)
    worker.process.kill()
    worker.process.join()
    assert worker.tried(folder / "motor.xml", "MJCF", 60.0)["result"] == "crashed"
    assert worker.tried(folder / "motor.xml", "MJCF", 60.0)["result"] == "refused"
    worker.process.kill()


def test_a_file_whose_comparison_exceeds_the_time_limit_ran(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(corpora, "difference", lambda *_: time.sleep(60))
    worker = Worker([], 0.001)  # a fork of this process
    found = worker.tried(folder / "runs.xml", "MJCF", 10.0)
    assert (found["result"], found["not compared"]) == ("ran", corpora.LARGE)
    assert worker.tried(folder / "runs.xml", "MJCF", 0.0)["result"] == "time limit"
    worker.process.kill()


def test_files_are_named_by_source_and_hash(folder: Path) -> None:
    """Of a repository its name and commit, of another folder its name."""
    rows = [
        {"file": str(folder / name), "format": "MJCF", "result": "ran"} for name in ("runs.xml", "motor.xml")
    ]
    rows[0]["difference"] = 2e-9
    digest = hashlib.sha256((folder / "runs.xml").read_bytes()).hexdigest()
    write_hashes(rows, [folder], folder / "table.csv")
    first = f"{folder.name},,runs.xml,{digest},MJCF,ran,,2.0e-09"
    assert (folder / "table.csv").read_text().splitlines()[1] == first
    run = partial(subprocess.run, cwd=folder, check=True, capture_output=True)
    run(["git", "init", "-q"])
    run(["git", "remote", "add", "origin", "https://host/owner/name.git"])
    run(["git", "-c", "user.name=a", "-c", "user.email=b", "commit", "-q", "--allow-empty", "-m", "c"])
    write_hashes(rows, [folder], folder / "table.csv")
    name, commit, *rest = (folder / "table.csv").read_text().splitlines()[1].split(",")
    assert (name, len(commit), rest[:2]) == ("owner/name", 40, ["runs.xml", digest])


def test_times_at_equal_error_are_interpolated() -> None:
    """By powers: a hundredth of the error for ten times the time."""
    runs = [[0, 1e-2, 1.0, 0], [0, 1e-4, 10.0, 0]]
    assert time_at(runs, 1e-3) == pytest.approx(10**0.5)
    assert time_at(runs, 1e-5) == float("inf")
