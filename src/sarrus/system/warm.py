"""Compiling the kernels of the built-in elements on all processors; they meet in the cache on disk."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context

from .._jit.cache import folder
from .group import built_in_driver

MOST_PROCESSES = 4  # each takes a second to start, and 200 MB
MARK = "complete"  # file beside the kernels: all of them are there


def warm(
    groups: Sequence[tuple[str, ...]], progress: Callable[[str], None], processes: int | None = None
) -> None:
    """Put the drivers of groups of operators into the cache, by several processes.

    Does nothing if they are there, or if one processor would have to do it alone: whoever uses a kernel compiles it.

    Parameters
    ----------
    groups : names of operators that are computed together
    progress : called with the names after each
    processes : how many; by default one for each processor, but not more than four
    """
    processes = min(os.cpu_count() or 1, MOST_PROCESSES) if processes is None else processes
    mark = folder() / MARK
    if processes < 2 or mark.exists():
        return
    try:
        with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
            for done in as_completed([pool.submit(_compile, names) for names in groups]):
                progress(" ".join(done.result()))
    except (BrokenProcessPool, OSError):  # such as a script without `if __name__ == "__main__"`
        return
    mark.touch()


def _compile(names: tuple[str, ...]) -> tuple[str, ...]:
    built_in_driver(names)
    return names
