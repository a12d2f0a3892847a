"""Check before a run that its results fit into memory."""

from __future__ import annotations

import os

from ...system import System
from .stepping.stepper import RunFailure

NUMBER = 8  # bytes
ALWAYS = 1_000_000  # bytes that are not worth asking for
STEPS = 2000  # stored steps that a run is taken to have at least


def bytes_of(system: System, rows: int) -> int:
    """Return the memory of a number of states."""
    return NUMBER * rows * (3 * system.nq + system.m + 5)


def available() -> int:
    """Free memory of this computer, or a very large number where it is unknown. [bytes]"""
    try:
        with open("/proc/meminfo", encoding="ascii") as lines:
            message = dict(line.split(":", 1) for line in lines)
        return 1024 * int(message["MemAvailable"].split()[0])
    except (OSError, KeyError, ValueError):
        pass
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return 2**62


def refuse_too_large(system: System, rows: int, all_steps: bool) -> None:
    """Refuse a run whose states do not fit.

    Raises
    ------
    RunFailure
        With the number of bytes.
    """
    wanted = bytes_of(system, rows + (STEPS if all_steps else 0))
    if wanted > ALWAYS and wanted > 0.9 * (free := available()):
        raise RunFailure(
            "memory",
            f"{rows} states of {system.name} take {wanted / 1e9:.3g} GB ({wanted} bytes), but {free / 1e9:.3g} GB are "
            "free. Give fewer times in t_eval, or save=... to write them to disk as they are computed.",
        )
