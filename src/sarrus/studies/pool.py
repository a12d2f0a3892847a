"""Execution of cases: in this process, in worker processes, or in any executor of ``concurrent.futures``."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import replace
from multiprocessing.context import SpawnContext, SpawnProcess
from multiprocessing.process import current_process, parent_process
from threading import Thread
from typing import Any

from .._jit.linking.compilation import VARIABLE
from ..model import SarrusError
from .case import Outcome, Task, outcome_of

Values = dict[str, float]
Write = Callable[[int, Outcome], None]
# raises TimeLimit when the time of all cases is over; else the seconds that are left
Tick = Callable[[], float]
Jobs = dict[int, Values]

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
SCRIPT = b"__main__"  # in a packed task: it holds a function of the user's script
GUARD = (
    'a study with functions of a script starts processes that read the script again. Put it under "if __name__ == '
    '"__main__":", or take workers=1.'
)
AT_ONCE = 1000  # cases handed to an executor of the user's, which has a queue of its own
PAUSE = 0.5  # s between two looks at the clock while cases run elsewhere
FORGET = 0.2  # s that a pool is given to forget what is queued
AHEAD = 3  # cases in hand for each worker, so that none waits for the next


def available() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def run_here(task: Task, jobs: Jobs, write: Write, tick: Tick) -> None:
    """Run the cases in sequence in this process; a case interrupted by the total time limit has no result."""
    for case, values in jobs.items():
        outcome = replace(task, time_limit=min(task.time_limit, tick())).outcome(values)
        if not outcome.success:
            tick()
        write(case, outcome)


def run_in(executor: Executor, task: Task, jobs: Jobs, write: Write, tick: Tick) -> None:
    """In an executor of the user's.

    Raises
    ------
    SarrusError
        If it breaks; the results so far are stored.
    """
    packed, left = task.packed(), dict(jobs)
    task.prepare()
    for case, done in _passed(executor, packed, jobs, AT_ONCE, tick):
        if not isinstance(done.exception(), BrokenExecutor):
            left.pop(case)
            write(case, _outcome(task, done))
    if left:
        raise SarrusError(
            f"the executor broke with {len(left)} cases left. Give a new one to go on with them."
        )


def run_in_processes(task: Task, jobs: Jobs, write: Write, workers: int, tick: Tick) -> None:
    """In worker processes with one thread each. Who dies is replaced, and what was in hand is run again.

    After a death the cases that were in hand are run one at a time, so that the one that kills its worker is known: it
    is recorded as failed, and no other.
    """
    packed, left = task.packed(), dict(jobs)
    _refuse_interactive(packed)

    def note(case: int, outcome: Outcome) -> None:
        left.pop(case)
        write(case, outcome)

    task.prepare()
    while left:
        before = len(left)
        suspects = _until_death(task, packed, left, note, workers, AHEAD * workers, tick)
        if suspects and before == len(left) and SCRIPT in packed:
            raise SarrusError(GUARD)
        while suspects:
            dead = _until_death(task, packed, {case: left[case] for case in suspects}, note, 1, 1, tick)
            for case in dead:
                note(case, _lost(task, "its worker process died, twice. Give it more memory."))
            suspects = [case for case in suspects if case in left]


def _until_death(
    task: Task, packed: bytes, jobs: Jobs, note: Write, workers: int, ahead: int, tick: Tick
) -> list[int]:
    """Run cases in a pool of its own until all are done or a worker dies; the cases that were in hand then."""
    suspects: list[int] = []
    with _one_thread(), _pool(min(workers, len(jobs)), packed) as pool:
        try:
            for case, done in _passed(pool, packed, dict(jobs), ahead, tick):
                if isinstance(done.exception(), BrokenExecutor):
                    suspects.append(case)
                else:
                    note(case, _outcome(task, done))
        except BaseException:
            _kill(pool)  # its end would wait for the cases in hand
            raise
    return suspects


def _kill(pool: ProcessPoolExecutor) -> None:
    """End the workers and their cases, after removing the cases that no worker has started."""
    workers = list((pool._processes or {}).values())
    pool.shutdown(wait=False, cancel_futures=True)
    time.sleep(FORGET)
    for worker in workers:
        worker.kill()


def _passed(
    executor: Executor, packed: bytes, jobs: Jobs, ahead: int, tick: Tick
) -> Iterator[tuple[int, Future[Outcome]]]:
    """Hand cases to an executor, and yield them as they are done; after a death no more are handed."""
    waiting, in_hand = iter(jobs.items()), dict[Future[Outcome], int]()
    alive = True
    try:
        while True:
            while alive and len(in_hand) < ahead and (job := next(waiting, None)):
                try:
                    in_hand[executor.submit(outcome_of, packed, job[1])] = job[0]
                except BrokenExecutor:
                    alive = False
            if not in_hand:
                return
            tick()
            for done in wait(in_hand, PAUSE, return_when=FIRST_COMPLETED).done:
                alive = alive and not isinstance(done.exception(), BrokenExecutor)
                yield in_hand.pop(done), done
    finally:
        for future in in_hand:
            future.cancel()


def _outcome(task: Task, done: Future[Outcome]) -> Outcome:
    if (wrong := done.exception()) is None:
        return done.result()
    return _lost(task, f"its worker gave up: {type(wrong).__name__}: {wrong}")


def _lost(task: Task, message: str) -> Outcome:
    return Outcome(False, message, (float("nan"),) * len(task.responses), 0.0)


def _refuse_interactive(packed: bytes) -> None:
    if SCRIPT in packed and not hasattr(sys.modules["__main__"], "__file__"):
        message = "a function of an interactive session cannot be sent to another process"
        raise SarrusError(f"{message}. Define it in a module, or take workers=1.")


def refuse_inside_start() -> None:
    """Raise a SarrusError where a worker process is running the user's script before its work."""
    if getattr(current_process(), "_inheriting", False):
        raise SarrusError(GUARD)


class _Worker(SpawnProcess):
    """A process that does not run the user's script again: cases import what they need."""

    def start(self) -> None:
        with _without_script():
            super().start()


class _Spawn(SpawnContext):
    Process = _Worker


def _pool(workers: int, packed: bytes) -> ProcessPoolExecutor:
    context = SpawnContext() if SCRIPT in packed else _Spawn()
    return ProcessPoolExecutor(workers, mp_context=context, initializer=_behave)


def _behave() -> None:
    """In a worker: leave Ctrl-C and progress to the parent, and end when the parent has ended, even by force."""
    os.environ[VARIABLE] = "0"
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@contextmanager
def _without_script() -> Iterator[None]:
    """Hide the main module's file: a new process would run it first, and with it the study, again and again."""
    main: Any = sys.modules["__main__"]
    removed = {name: main.__dict__.pop(name) for name in ("__file__", "__spec__") if name in main.__dict__}
    main.__spec__ = None
    try:
        yield
    finally:
        main.__dict__.update(removed)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Processes that start now use one thread each for linear algebra."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
