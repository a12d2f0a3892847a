"""What is saved cannot be lost or lie: other data, other writers, damage, crashes at any moment, and full disks."""

import errno
import io
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.dynamics.time_loop import recording
from sarrus.analyses.dynamics.time_loop import time_loop as march
from sarrus.model import SarrusError
from sarrus.model.expression.tree import REGISTRY
from sarrus.results.saving import checked_file, saved
from sarrus.results.saving.versions import versions

ROOT = Path(__file__).parents[2]
GIVEN = {"until": 1.0, "t_eval": np.linspace(0, 1, 201), "method": sr.HHT(rtol=1e-6, atol=1e-8)}
STATES = ("t", "q", "v", "a", "lam", "history", "kinetic_energy", "violation")


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks of 23 states, a checkpoint after every 40 steps."""
    for owner, name, value in (
        (recording, "PAUSE", 0.0),
        (recording, "PATIENT", 0.0),
        (march, "CHUNK", 40),
        (saved, "BYTES", 4000),
    ):
        monkeypatch.setattr(owner, name, value)


@pytest.fixture(scope="module")
def plain() -> sr.Trajectory:
    return sr.simulate(slider_crank(), **GIVEN)


def stop(t: float) -> None:
    if t > 0.5:
        raise KeyboardInterrupt


def same(one: sr.Trajectory, other: sr.Trajectory) -> bool:
    return all(
        np.array_equal(np.asarray(getattr(one, n)), np.asarray(getattr(other, n)), equal_nan=True)
        for n in STATES
    )


def cut_short(folder: Path) -> sr.Trajectory:
    return sr.simulate(slider_crank(), save=folder, progress=stop, **GIVEN)


# ---------------------------------------------------------------------------------------------- other data
def foreign_group(folder: Path) -> None:
    zarr = pytest.importorskip("zarr")
    zarr.open_group(folder, mode="w").create_array("measurements", shape=(9,), dtype="f8")[:] = 1.0
    (folder / "notes.txt").write_text("irreplaceable")


def foreign_names(folder: Path) -> None:
    folder.mkdir()
    for name in ("lock", "recipe.data"):
        (folder / name).write_text("mine")


def foreign_json(folder: Path) -> None:
    folder.mkdir()
    (folder / "zarr.json").write_text("[1, 2]")


def foreign_file(folder: Path) -> None:
    folder.write_text("mine")


def contents(folder: Path) -> dict[str, bytes]:
    return {str(p): p.read_bytes() for p in [folder, *folder.rglob("*")] if p.is_file()}


@pytest.mark.parametrize("make", [foreign_group, foreign_names, foreign_json, foreign_file])
@pytest.mark.parametrize("overwrite", [False, True])
def test_what_is_no_run_is_never_touched(
    make: Callable[[Path], None], overwrite: bool, tmp_path: Path
) -> None:
    folder = tmp_path / "thesis"
    make(folder)
    before = contents(folder)
    with pytest.raises(SarrusError, match=r"thesis: is there and is no saved run.* Choose another name"):
        sr.simulate(slider_crank(), save=sr.Save(folder, overwrite=overwrite), **GIVEN)
    assert contents(folder) == before


def test_files_of_others_in_the_folder_of_a_run_stay_when_it_is_replaced(tmp_path: Path) -> None:
    run = tmp_path / "run"
    sr.simulate(slider_crank(), until=0.01, save=run)
    others = [
        run / name for name in ("q/code.py", "lam/course/notes.txt", "v/c.old", "a/c.0.0.bak", "cv.pdf")
    ]
    others.append(run / "q" / "c.7.0" / "thesis.tex")  # a folder that is named as a chunk
    for path in others:
        path.parent.mkdir(exist_ok=True)
        path.write_text("mine")
    sr.simulate(slider_crank(), until=0.01, save=sr.Save(run, overwrite=True))
    assert all(path.read_text() == "mine" for path in others)


@pytest.mark.usefixtures("small")
@pytest.mark.parametrize("name", ["q", "q/c.0.0", "lock", "zarr.json", "recipe.data.draft"])
@pytest.mark.parametrize("overwrite", [False, True])
def test_nothing_is_written_or_removed_through_links_in_the_folder_of_a_run(
    name: str, overwrite: bool, tmp_path: Path
) -> None:
    run, home = tmp_path / "run", tmp_path / "home"
    cut_short(run)
    (home / "code").mkdir(parents=True)
    (home / "code" / "thesis.tex").write_text("mine")
    (home / "c.0.0").write_bytes((run / "zarr.json").read_bytes() if name == "zarr.json" else b"mine")
    place = run / name
    shutil.rmtree(place) if place.is_dir() else place.unlink(missing_ok=True)
    place.symlink_to(home if name == "q" else home / "c.0.0")
    before = contents(home)
    with pytest.raises(SarrusError, match="which is not touched" if overwrite else None):
        sr.simulate(slider_crank(), save=sr.Save(run, overwrite=True), **GIVEN) if overwrite else sr.resume(
            run
        )
    assert contents(home) == before


@pytest.mark.parametrize("name", ["cases.jsonl", "lock", "model"])
def test_nothing_is_written_through_links_in_the_folder_of_a_study(name: str, tmp_path: Path) -> None:
    def study() -> Any:
        model = sr.load("slider_crank")
        return sr.study(
            model,
            {"spring.k": [10]},
            "slider.x",
            analysis=sr.Simulation(0.01, steps=2),
            folder=tmp_path / "study",
            workers=1,
        )

    home = tmp_path / "home"
    home.mkdir()
    (home / "cv.pdf").write_text("mine")
    study()
    place = tmp_path / "study" / name
    shutil.rmtree(place) if place.is_dir() else place.unlink(missing_ok=True)
    place.symlink_to(home if name == "model" else home / "cv.pdf")
    with pytest.raises(SarrusError, match="is a link to data elsewhere"):
        study()
    assert contents(home) == {str(home / "cv.pdf"): b"mine"}


@pytest.mark.parametrize("overwrite", [False, True])
def test_runs_and_studies_take_an_empty_folder(overwrite: bool, tmp_path: Path) -> None:
    for name in ("run", "study"):
        (tmp_path / name).mkdir()
    saved = sr.simulate(slider_crank(), save=sr.Save(tmp_path / "run", overwrite=overwrite), **GIVEN)
    assert sr.load_run(tmp_path / "run").t.tolist() == saved.t.tolist()
    short = sr.Simulation(0.01, steps=2)
    sr.study(
        slider_crank(), {"spring.k": [10]}, "slider.x", analysis=short, folder=tmp_path / "study", workers=1
    )
    assert len(sr.open_study(tmp_path / "study")) == 1


@pytest.mark.usefixtures("small")
def test_a_run_is_replaced_only_where_that_is_said(tmp_path: Path, plain: sr.Trajectory) -> None:
    folder = tmp_path / "run"
    cut_short(folder)
    (folder / "notes.txt").write_text("irreplaceable")
    with pytest.raises(
        FileExistsError, match=r"cut short. Continue it with sarrus.resume\('.*run'\), or pass"
    ):
        sr.simulate(slider_crank(), save=folder, **GIVEN)
    sr.resume(folder)
    with pytest.raises(
        SarrusError, match=r"holds a finished run. Open it with sarrus.load_run.*overwrite=True"
    ):
        sr.simulate(slider_crank(), save=folder, **GIVEN)
    assert same(sr.load_run(folder), plain)
    (folder / saved.CHECKPOINT).unlink()
    with pytest.raises(SarrusError, match=r"holds a damaged run. Pass overwrite=True"):
        sr.simulate(slider_crank(), save=folder, **GIVEN)
    with pytest.raises(SarrusError, match=r"checkpoint.npz: is missing"):
        sr.resume(folder)
    other = sr.simulate(slider_crank(), save=sr.Save(folder, overwrite=True), until=0.2)
    assert same(sr.load_run(folder), other)
    assert (folder / "notes.txt").read_text() == "irreplaceable"


def test_zarr_opens_a_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, plain: sr.Trajectory) -> None:
    zarr = pytest.importorskip("zarr")
    monkeypatch.setattr(saved, "BYTES", 4000)
    sr.simulate(slider_crank(), save=tmp_path / "run", **GIVEN)
    group = zarr.open_group(tmp_path / "run", mode="r")
    for name in ("t", "q", "v", "a", "lam"):
        assert np.array_equal(group[name][:], getattr(plain, name)), name
    assert np.array_equal(group["history"][: plain.nsteps], plain.history)
    assert group["q"].metadata.dimension_names == ("time", "coordinate")
    assert group.attrs["bodies"] == list(plain.bodies)
    assert all(path.stat().st_size for path in (tmp_path / "run").rglob("*"))


# ------------------------------------------------------------------------------------------- other writers
WRITER = """
import sys, time, sarrus as sr
from tests.analyses import test_saved_folders as here
def wait(t):
    if t > 0.2:
        print("writing", flush=True)
        time.sleep(100)
here.recording.PAUSE, here.march.CHUNK = 0.0, 40
sr.simulate(here.slider_crank(), save=sys.argv[1], progress=wait, **here.GIVEN)
"""


def writer(code: str, *arguments: object) -> subprocess.Popen[str]:
    """A process of its own that has begun to write."""
    command = [sys.executable, "-c", code, *map(str, arguments)]
    found = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    assert found.stdout is not None
    assert found.stdout.readline() == "writing\n"
    return found


def test_a_second_writer_is_refused_and_a_dead_one_is_replaced(tmp_path: Path, plain: sr.Trajectory) -> None:
    folder = tmp_path / "run"
    first = writer(WRITER, folder)
    try:
        told = rf"run: is being written by process {first.pid} on {os.uname().nodename}. Wait until it ends"
        for overwrite in (False, True):
            with pytest.raises(SarrusError, match=told):
                sr.simulate(slider_crank(), save=sr.Save(folder, overwrite=overwrite), **GIVEN)
        with pytest.raises(SarrusError, match=told):
            sr.resume(folder)
        assert sr.load_run(folder).status == "cut short"
    finally:
        first.kill()
        first.communicate()
    assert same(sr.resume(folder), plain)


def test_a_second_writer_in_the_same_process_is_refused(tmp_path: Path) -> None:
    refused = []

    def again(t: float) -> None:
        with pytest.raises(SarrusError, match=f"is being written by process {os.getpid()} on"):
            sr.simulate(slider_crank(), save=sr.Save(tmp_path / "run", overwrite=True), **GIVEN)
        refused.append(t)

    run = sr.simulate(slider_crank(), save=tmp_path / "run", progress=again, **GIVEN)
    assert run.success
    assert refused


def test_where_files_cannot_be_locked_the_process_that_is_named_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from sarrus.results.saving import folder_lock

    def none(file: int, *, blocking: bool) -> bool:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("filelock.lock_descriptor", none)
    cut_short(tmp_path / "run")
    lock = tmp_path / "run" / folder_lock.LOCK
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    for process, host in ((os.getpid(), os.uname().nodename), (1, "elsewhere")):
        lock.write_text(json.dumps({"process": process, "host": host}))
        with pytest.raises(SarrusError, match=f"is being written by process {process} on {host}"):
            sr.resume(tmp_path / "run")
    lock.write_text(json.dumps({"process": dead.pid, "host": os.uname().nodename}))
    assert sr.resume(tmp_path / "run").success


# -------------------------------------------------------------------------------------------------- damage
@pytest.mark.usefixtures("small")
def test_chunks_are_bound_to_their_places(tmp_path: Path) -> None:
    """A chunk of another place or array, or of a run that differs in one number, is refused where it is read."""
    folder = tmp_path / "run"
    sr.simulate(slider_crank(), save=folder, **GIVEN)
    chunks = sorted((folder / "q").glob("c.*"))
    assert len(chunks) == 9
    whole = chunks[3].read_bytes()
    for other in (chunks[4], folder / "v" / chunks[3].name, folder / "a" / chunks[3].name):
        chunks[3].write_bytes(other.read_bytes())
        run = sr.load_run(folder)
        assert np.array_equal(run.q[:60], sr.load_run(folder).q[:60])
        for read in (
            lambda run=run: run.q[75],
            lambda run=run: run.q[60:80],
            lambda run=run: np.asarray(run.q),
        ):
            with pytest.raises(
                SarrusError, match=r"q/c\.3\.0: is damaged: its checksum is wrong. Restore it"
            ):
                read()
    chunks[3].write_bytes(whole[:-1])
    with pytest.raises(SarrusError, match=r"c\.3\.0: has \d+ bytes in place of \d+"):
        sr.load_run(folder)


@pytest.mark.usefixtures("small")
def test_saved_states_are_indexed_as_arrays(tmp_path: Path) -> None:
    run = sr.simulate(slider_crank(), save=tmp_path / "run", **GIVEN)
    whole = np.asarray(run.q)
    several = np.array([5, 60, -1])
    for key in (7, -1, np.int64(80), (..., 0), (None, 3), (several, 1), several, (slice(None, None, -7), 2)):
        assert np.array_equal(run.q[key], whole[key])
    for wrong in (1.5, 201, -202, "q"):
        with pytest.raises(IndexError):
            run.q[wrong]


@pytest.mark.usefixtures("small")
def test_a_run_is_verified_before_it_is_continued(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    cut_short(folder)
    chunk = folder / "lam" / "c.1.0"
    chunk.write_bytes(bytes(chunk.stat().st_size))
    before = contents(folder)
    with pytest.raises(ValueError, match=r"lam/c\.1\.0: is damaged"):
        sr.resume(folder)
    assert contents(folder) == before


def change_attributes(folder: Path, **changes: Any) -> None:
    about = json.loads((folder / "zarr.json").read_text())
    about["attributes"] |= changes
    (folder / "zarr.json").write_text(json.dumps(about))


def test_format_version_and_attributes_are_checked(tmp_path: Path) -> None:
    folder, copy = tmp_path / "run", tmp_path / "copy"
    cut_short(folder)
    for changes, told in (
        ({"format": 999}, "in format 999, and Sarrus .* reads format 9. Open it with Sarrus .*, or simulate"),
        ({"format": 1}, "in format 1, and"),
        ({"format": 6}, "in format 6, and"),
        ({"name": "other"}, "zarr.json: is damaged"),
        ({"bodies": ["a", "b", "c"]}, "zarr.json: is damaged"),
        ({"chunk": 7}, "zarr.json: is damaged"),
    ):
        shutil.copytree(folder, copy)
        change_attributes(copy, **changes)
        for use in (sr.load_run, sr.resume):
            with pytest.raises(SarrusError, match=told):
                use(copy)
        shutil.rmtree(copy)


def test_another_version_opens_a_run_but_does_not_continue_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "run"
    found, here = cut_short(folder), versions()
    monkeypatch.setattr(saved, "versions", lambda: here | {"sarrus": "9.9"})
    assert same(sr.load_run(folder), found)
    for use in (sr.resume, sr.repeat):
        with pytest.raises(
            SarrusError, match=r"was written by Sarrus .*, and this is 9.9. .* install Sarrus"
        ):
            use(folder)


def test_other_versions_of_what_numbers_depend_on_are_a_warning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, here = tmp_path / "run", versions()
    cut_short(folder)
    monkeypatch.setattr(saved, "versions", lambda: here | {"numba": "9.9"})
    with pytest.warns(
        sr.SarrusWarning, match=r"started with numba \d.*, resumed with numba 9.9. The last digits"
    ):
        run = sr.resume(folder)
    assert len(run.warnings) == len(sr.load_run(folder).warnings) == 1


def test_a_foreign_recipe_is_not_opened(tmp_path: Path) -> None:
    """Neither one without a checksum, nor one of another run, nor one with other fields."""
    folder, other = tmp_path / "run", tmp_path / "other"
    cut_short(folder)
    sr.simulate(slider_crank(), save=other, until=0.1)
    recipe = folder / saved.RECIPE
    own = checked_file.read_checked(recipe)
    recipe.write_bytes(b"{}")
    with pytest.raises(SarrusError, match=r"recipe.data: is damaged"):
        sr.resume(folder)
    shutil.copy(other / saved.RECIPE, recipe)
    with pytest.raises(SarrusError, match=r"recipe.data: belongs to another run"):
        sr.repeat(folder)
    for content in (own[:-9], own.replace(b'"HHT"', b'"TTH"'), own.replace(b'"alpha"', b'"omega"')):
        forge(folder, content)
        with pytest.raises(SarrusError, match=r"cannot be opened .*Another state of Sarrus wrote it"):
            sr.resume(folder)


def forge(folder: Path, content: bytes) -> None:
    """Replace the recipe, with right checksums."""
    checked_file.write_checked(folder / saved.RECIPE, content)
    change_attributes(folder, recipe=checked_file.checksum(content).hex())


@pytest.mark.parametrize(
    "content",
    [
        b"cos\nsystem\n(S'touch {ran}'\ntR.",
        b'cbuiltins\nexec\n(S\'open("{ran}", "w")\'\ntR.',
        b"csarrus.results.saving.saved\nos.system\n(S'touch {ran}'\ntR.",
        b"csarrus.io\nload_urdf\n(S'{ran}'\ntR.",
        b"csarrus.results.saving.checked_file\nwrite_checked\n(S'{ran}'\nS'x'\ntR.",
        b"\x80\x04\x8c\x1bsarrus.results.saving.saved\x8c\tos.system\x93\x8c\x05false\x85R.",
        b"csarrus.__main__\nmain\n(tR.",
        b"cnumpy\nload\n(S'{ran}'\ntR.",
        b"csarrus._jit.linking.folders\nPath\n(S'{ran}'\ntR.",
        b"csarrus.model.bodies.body\nBody\n(N(S'forged'\nI7\ndtb.",
        b"csarrus.model.expression.tree\nfunction_named\n(S'sin'\ntR(S'value'\nI7\ndb.",
        b'{"mapping": {"model": {"array": ["|O", [1]]}}}\n' + bytes(8),
        b'{"mapping": {"model": {"os.system": {"command": "touch {ran}"}}}}\n',
        b'{"mapping": {"model": {"Body": {"name": "b"}}}}\n',
        b"[" * 100_000,
    ],
)
def test_forged_recipes_run_nothing(content: bytes, tmp_path: Path) -> None:
    """With right checksums, too: pickles, objects, and classes that are no data are all refused."""
    folder, ran = tmp_path / "run", tmp_path / "ran"
    cut_short(folder)
    forge(folder, content.replace(b"{ran}", str(ran).encode()))
    for opening in (sr.resume, sr.repeat):
        with pytest.raises(SarrusError, match=r"recipe\.data: cannot be opened"):
            opening(folder)
    assert not ran.exists()
    assert not hasattr(sr.Body, "forged")  # nor is a class or a function of formulas changed
    assert REGISTRY["sin"].value != 7


def test_no_file_of_a_run_is_a_pickle(tmp_path: Path) -> None:
    """What is written names no class of Python, and only the caches of kernels and worker processes unpickle."""
    event = sr.Event("slider.x - 4.1", reset=lambda t, q, v: v, name="gate")
    run = sr.simulate(slider_crank(), until=3.0, save=tmp_path / "run", events=event, store="steps")
    assert run.events
    for content in contents(tmp_path / "run").values():
        assert b"sarrus.model" not in content
        assert b"numpy." not in content
    source = ROOT / "src" / "sarrus"
    users = {
        str(path.relative_to(source)) for path in source.rglob("*.py") if "import pickle" in path.read_text()
    }
    assert users == {"_jit/linking/cache.py", "studies/case.py"}


@pytest.mark.slow
def test_random_damage_is_refused_or_harmless() -> None:
    """Run folders and ledgers of studies; the whole attack is ``python benchmarks/attack_saving.py --damage``."""
    script = [
        sys.executable,
        "benchmarks/attack_saving.py",
        "--damage",
        "--folders",
        "60",
        "--ledgers",
        "100",
    ]
    done = subprocess.run(script, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "FAILED" not in done.stdout


# ------------------------------------------------------------------------------------------------- crashes
class Crash(BaseException):
    """The end of a process."""


@pytest.mark.slow
@pytest.mark.usefixtures("small")
@pytest.mark.parametrize("overwrite", [False, True])
def test_a_run_that_crashed_before_its_first_checkpoint_is_begun_again(
    overwrite: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, plain: sr.Trajectory
) -> None:
    """The process ends before each of the files that are written up to the first checkpoint."""
    write, create, left = checked_file.replace_file, saved.stored_array.create, [0]

    def crash(path: Path, data: bytes) -> None:
        left[0] -= 1
        if left[0] < 0:
            path.with_name(path.name + checked_file.DRAFT).write_bytes(data[: len(data) // 2])
            raise Crash
        write(path, data)

    def crash_within(folder: Path, *given: Any) -> None:
        left[0] -= 1
        create(folder, *given)
        if left[0] < 0:
            (folder / saved.METADATA).write_text("{")
            raise Crash

    for count in range(20):
        folder, left[0] = tmp_path / f"run{count}", count
        if overwrite:
            cut_short(folder)
        with monkeypatch.context() as patch, suppress(Crash):
            patch.setattr(checked_file, "replace_file", crash)
            patch.setattr(saved, "replace_file", crash)
            patch.setattr(saved.stored_array, "create", crash_within)
            sr.simulate(slider_crank(), save=sr.Save(folder, overwrite=overwrite), **GIVEN)
        if (folder / saved.CHECKPOINT).exists():
            break
        if count % 2:
            told = "before its first checkpoint. Begin it again with sarrus.resume"
            with pytest.raises(FileNotFoundError, match=told):
                sr.load_run(folder)
            assert same(sr.resume(folder), plain)
        else:
            with pytest.raises(FileNotFoundError, match=r"holds no saved run|before its first checkpoint"):
                sr.load_run(folder)
            assert same(sr.simulate(slider_crank(), save=folder, **GIVEN), plain)
    arrays = len((*saved.OVER_TIME, saved.HISTORY))
    assert count == 3 + arrays  # recipe, attributes and first checkpoint


@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", [sr.HHT(), sr.GeneralizedAlpha(), sr.Radau(), sr.ODE()], ids=repr)
def test_a_run_is_resumed_to_the_same_bits_and_counts_from_every_checkpoint(
    method: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From the one at the start, and from those behind resets, where methods start anew, on."""
    balls = [
        sr.Body(n, mass=1, inertia=(1, 1, 1), position=(x, 0, 0.3)) for x, n in enumerate(("one", "two"))
    ]
    resets = [sr.Event(f"{b.name}.z", reset=sr.Impact(e)) for b, e in zip(balls, (0.8, 0.7), strict=True)]
    system = sr.System(sr.Model("balls", bodies=balls, gravity=(0, 0, -9.81)))
    given = {
        "until": 1.0,
        "t_eval": np.linspace(0, 1, 31),
        "events": resets,
        "method": replace(method, max_step=0.04),
    }
    for name, value in (("PAUSE", 0.0), ("PATIENT", 0.0), ("WATCHED", 2)):
        monkeypatch.setattr(march if name == "WATCHED" else recording, name, value)
    plain, stretches = sr.simulate(system, **given), list[float]()
    sr.simulate(system, progress=stretches.append, **given)
    assert len(plain.events) >= 4
    for count in range(0, len(stretches), 4):
        calls, pause = [], 0.0 if count else 1e9  # at 0 only the checkpoint of the start is there

        def stop(t: float, calls: list[float] = calls, count: int = count) -> None:
            calls.append(t)
            if len(calls) > count:
                raise KeyboardInterrupt

        monkeypatch.setattr(recording, "PAUSE", pause)
        folder = tmp_path / f"run{count}"
        assert sr.simulate(system, save=folder, progress=stop, **given).status == "stopped"
        resumed = sr.resume(folder)
        assert same(resumed, plain), count
        for name in ("nfev", "njev", "nlu", "nsteps", "nrejected", "status"):
            assert getattr(resumed, name) == getattr(plain, name), (count, name)
        assert [(e.name, e.t) for e in resumed.events] == [(e.name, e.t) for e in plain.events]


@pytest.mark.usefixtures("small")
def test_chunks_are_on_the_disk_before_a_checkpoint_refers_to_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    flushed, wanted = set[Path](), list[Path]()
    fsync, write = os.fsync, checked_file.write_checked

    def note(number: int) -> None:
        flushed.add(Path(f"/proc/self/fd/{number}").readlink())
        fsync(number)

    def check(path: Path, content: bytes) -> None:
        chunks = [p for p in path.parent.glob("*/c.*") if p.parent.name != "history"]
        assert flushed >= {*chunks, *(p.parent for p in chunks)}
        wanted.extend(chunks)
        write(path, content)
        assert path.with_name(path.name + checked_file.DRAFT) in flushed
        assert path.parent in flushed

    monkeypatch.setattr(os, "fsync", note)
    monkeypatch.setattr(saved, "write_checked", check)
    sr.simulate(slider_crank(), save=tmp_path / "run", **GIVEN)
    assert len(set(wanted)) > 50


def test_the_checkpoint_of_an_earlier_version_is_read_but_not_resumed(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    sr.simulate(slider_crank(), save=folder, until=0.1)
    former, content = {n: x for n, x in saved.checkpoint(folder).items() if "." not in n}, io.BytesIO()
    np.savez(content, **former)
    checked_file.write_checked(folder / saved.CHECKPOINT, content.getvalue())
    assert sr.load_run(folder).success
    with pytest.raises(SarrusError, match="by an earlier version of Sarrus"):
        sr.resume(folder)


# ---------------------------------------------------------------------------------------------- full disks
LIMITED = """
import resource, sys, sarrus as sr
from tests.analyses import test_saved_folders as here
here.slider_crank()  # is read from a file that it writes
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), resource.RLIM_INFINITY))
here.recording.PAUSE = here.recording.PATIENT = 0.0
here.march.CHUNK, here.saved.BYTES = 40, 4000
made = sr.resume(sys.argv[1]) if sys.argv[3] == "resume" else sr.simulate(
    here.slider_crank(), save=sys.argv[1], **here.GIVEN)
print(made.status, len(made.t), made.success)
print(made.message)
"""


def limited(folder: Path, size: int, verb: str) -> list[str]:
    """Run with a limit of file sizes; what is printed."""
    command = [sys.executable, "-c", LIMITED, str(folder), str(size), verb]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.mark.slow
def test_a_limit_of_file_sizes_ends_in_a_result(tmp_path: Path, plain: sr.Trajectory) -> None:
    """At 1 kB nothing can be written, at 100 kB some checkpoints can; the run is completed without a limit."""
    folder = tmp_path / "run"
    told, message = limited(folder, 1000, "simulate")
    assert told == "not saved 0 False"
    assert "cannot be written (File too large). Raise the limit of file sizes" in message
    folder = tmp_path / "second"
    largest = 100_000
    told, message = limited(folder, largest, "simulate")
    status, count, success = told.rsplit(" ", 2)
    assert (status, success) == ("not saved", "False")
    assert 0 < int(count) < len(plain.t)
    assert "The run is safe up to t =" in message
    found = sr.load_run(folder)
    assert found.status == "cut short"
    assert np.array_equal(np.asarray(found.q)[:-1], plain.q[: int(count) - 1])  # then the last state
    assert limited(folder, largest, "resume")[0] == told
    assert same(sr.resume(folder), plain)


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """A small disk of its own, where that is allowed."""
    place = tmp_path / "disk"
    place.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(place)]
    if shutil.which("mount") is None or subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("no disk can be mounted")
    yield place
    subprocess.run(["umount", str(place)], check=True)


@pytest.mark.usefixtures("small")
def test_a_full_disk_ends_in_a_result_and_the_run_is_continued_when_there_is_space(
    disk: Path, plain: sr.Trajectory
) -> None:
    folder, ballast = disk / "run", disk / "ballast"
    ballast.write_bytes(bytes(760_000))
    cut = sr.simulate(slider_crank(), save=folder, **GIVEN)
    assert (cut.status, cut.success) == ("not saved", False)
    assert "No space left on device). Free disk space" in cut.message
    assert 0 < len(cut.t) < len(plain.t)
    assert np.array_equal(np.asarray(sr.load_run(folder).q)[:-1], plain.q[: len(cut.t) - 1])
    still = sr.resume(folder)
    assert (still.status, len(still.t) >= len(cut.t)) == ("not saved", True)
    ballast.unlink()
    assert same(sr.resume(folder), plain)


@pytest.mark.usefixtures("small")
def test_a_folder_that_cannot_be_written_ends_in_a_result(disk: Path) -> None:
    cut = cut_short(disk / "run")
    subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
    run = sr.simulate(slider_crank(), save=disk / "other", **GIVEN)
    assert (run.status, run.success, len(run.t)) == ("not saved", False, 0)
    assert "Read-only file system). Make it writable" in run.message
    resumed = sr.resume(disk / "run")
    assert resumed.status == "not saved"
    assert same(resumed, cut)
    assert same(sr.load_run(disk / "run"), cut)


def test_a_refusal_of_the_operating_system_ends_in_a_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever it refuses, at any checkpoint, also at the last one."""
    for count in (0, 1, 2):
        write, left = checked_file.write_checked, [count]

        def refuse(path: Path, content: bytes, left: list[int] = left, write: Any = write) -> None:
            left[0] -= 1
            if left[0] < 0:
                raise OSError(errno.EIO, "Input/output error")
            write(path, content)

        with monkeypatch.context() as patch:
            patch.setattr(saved, "write_checked", refuse)
            run = sr.simulate(slider_crank(), save=tmp_path / f"run{count}", **GIVEN)
        assert run.status == "not saved"
        assert "Input/output error" in run.message
    assert sr.resume(tmp_path / "run2").success


def test_a_run_is_not_read_with_another_system(tmp_path: Path) -> None:
    """Multipliers, and so reactions, would be taken from other joints without a word."""
    system, folder = slider_crank(), tmp_path / "run"
    run = sr.simulate(system, save=folder, **GIVEN)
    assert np.array_equal(sr.load_run(folder, system).reaction("pin").force, run.reaction("pin").force)
    joints = system.model.joints
    for others in (joints[::-1], joints[:-1]):
        other = sr.System(replace(system.model, joints=others, forces=[], drivers=[]))
        with pytest.raises(SarrusError, match=r"is a run of another system.*whose equations differ"):
            sr.load_run(folder, other)
