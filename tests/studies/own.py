"""Functions that studies in other processes call."""

import os
import signal
import time
from pathlib import Path
from typing import Any


def quick(system: Any) -> dict[str, float]:
    """A number of the system, at once."""
    return {"k": float(system.model.forces[0].k)}


def deadly(system: Any) -> dict[str, float]:
    """Kills its process where the stiffness is 13."""
    if quick(system)["k"] == 13.0:
        os.kill(os.getpid(), signal.SIGKILL)
    return quick(system)


def dies_once(system: Any) -> dict[str, float]:
    """Kills its process the first time that the stiffness is 13."""
    mark = Path(os.environ["SARRUS_TEST_MARK"])
    if quick(system)["k"] == 13.0 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return quick(system)


def slow(system: Any) -> dict[str, float]:
    """Takes a while."""
    time.sleep(0.05)
    return quick(system)


def picky(system: Any) -> dict[str, float]:
    """Does not like the stiffness 13."""
    if quick(system)["k"] == 13.0:
        raise ZeroDivisionError("thirteen")
    return quick(system)


def interrupts(system: Any) -> dict[str, float]:
    """Presses Ctrl-C where the stiffness is 13."""
    if quick(system)["k"] == 13.0:
        signal.raise_signal(signal.SIGINT)
    return quick(system)
