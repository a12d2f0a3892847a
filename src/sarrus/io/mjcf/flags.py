"""Options of an MJCF file that disable forces or constraints."""

from __future__ import annotations

from typing import Any

from .compiled import mujoco

WIDER = {"SPRING": ("PASSIVE",), "DAMPER": ("PASSIVE",)}  # one flag for both before MuJoCo 3.3.6
CONSTRAINTS = ("EQUALITY", "FRICTIONLOSS", "LIMIT", "CONTACT")


def disabled(compiled: Any, name: str) -> bool:
    """Return whether the file has ``<flag name="disable">``, or switches off all constraints, of which this is one."""
    words = (name, *WIDER.get(name, ()), *(("CONSTRAINT",) if name in CONSTRAINTS else ()))
    bits = (getattr(mujoco().mjtDisableBit, f"mjDSBL_{word}", 0) for word in words)
    return any(int(compiled.opt.disableflags) & int(bit) for bit in bits)


def no_passive_forces(compiled: Any) -> bool:
    """Return whether springs and dampers are disabled, and with them all passive forces, as of a fluid."""
    return disabled(compiled, "SPRING") and disabled(compiled, "DAMPER")


def enabled(compiled: Any, name: str) -> bool:
    """Return whether the file has ``<flag name="enable">``."""
    bit = int(getattr(mujoco().mjtEnableBit, f"mjENBL_{name}", 0))
    return bool(int(compiled.opt.enableflags) & bit)
