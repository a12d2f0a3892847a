"""A Dask cluster with a real scheduler and real workers, in processes of their own, over TCP."""

import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import Executor
from pathlib import Path

import numpy as np
import pytest
from tests.studies import own

from sarrus.model import Model
from sarrus.studies import Simulation, study

distributed = pytest.importorskip("distributed")
pytestmark = pytest.mark.needs("distributed")
ROOT = Path(__file__).parent.parent.parent


def started(*words: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "distributed.cli." + words[0], *words[1:]],
        stderr=subprocess.PIPE,
        text=True,
        cwd=ROOT,
    )


def said(process: subprocess.Popen[str], words: str) -> str:
    """The line of its log that holds some words."""
    assert process.stderr is not None
    for line in process.stderr:
        if words in line:
            return line
    raise AssertionError(f"the process ended without saying {words!r}")


@pytest.fixture(scope="module")
def executor() -> Iterator[Executor]:
    scheduler = started("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
    found = said(scheduler, "Scheduler at:").split()[-1]
    workers = [started("dask_worker", found, "--nthreads", "1", "--no-dashboard") for _ in range(2)]
    for worker in workers:
        said(worker, "Registered to:")
    with distributed.Client(found, set_as_default=False) as client:
        yield client.get_executor(pure=False)
    for process in (*workers, scheduler):
        process.terminate()
        process.communicate()


def test_a_cluster_gives_the_same_numbers(model: Model, executor: Executor) -> None:
    k, run = {"spring.k": [5, 10, 15, 20]}, Simulation(until=0.2, steps=50)
    there = study(model, k, "slider.x", analysis=run, executor=executor)
    here = study(model, k, "slider.x", analysis=run, workers=1)
    assert there.success.all()
    assert np.array_equal(here.found, there.found)


def test_failures_on_a_cluster(model: Model, executor: Executor) -> None:
    found = study(model, {"spring.k": [5, 13]}, {"k": "k"}, analysis=own.picky, executor=executor)
    assert found.failures == {1: "ZeroDivisionError: thirteen"}


def test_a_case_that_kills_workers_of_a_cluster_is_the_only_one_that_fails(
    model: Model, executor: Executor
) -> None:
    found = study(model, {"spring.k": [5, 13, 20]}, {"k": "k"}, analysis=own.deadly, executor=executor)
    assert found.success.tolist() == [True, False, True]
    assert "its worker gave up: KilledWorker" in found.failures[1]
