"""A vibration mode as a motion that is seen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..algebra import Array
from ..results import Modes, Trajectory
from ..system import System
from .browser import Page
from .looks import sketch
from .shows import animate

FRAMES = 121
SHARE = 0.12  # of the size of the drawing: the default amplitude of the largest coordinate
LASTS = 2.0  # [s] that one swing takes in the page, however quick the mode is


def animate_mode(
    found: Modes,
    system: System,
    mode: int = 0,
    file: str | Path | None = None,
    *,
    amplitude: float | None = None,
) -> Page | Path:
    """Play one swing of a vibration mode, without its growth or decay, again and again.

    Parameters
    ----------
    found : Modes
    system : the system that they belong to
    mode : counted from 0
    file : as for `animate`; left out, in the browser or the notebook
    amplitude : of the coordinate that swings most [m] or [-]; by default as much as is well seen

    Returns
    -------
    Page, or the path of the file

    Raises
    ------
    NoModeError
        If there is no such mode.
    """
    found.refuse_unknown(mode)
    size = sketch(system.model, found.q[None]).size
    shape = found.shapes[:, mode] * (SHARE * size if amplitude is None else amplitude)
    period = 1 / found.frequencies[mode] if found.frequencies[mode] > 0 else LASTS
    phase = np.linspace(0.0, 2 * np.pi, FRAMES)
    q, v = (_swing(found.q, shape, phase), _rates(shape, phase, 2 * np.pi / period))
    title = f"{found.name}: mode {mode}, {found.frequencies[mode]:.4g} Hz"
    empty = np.zeros((FRAMES, 0))
    run = Trajectory(
        name=title,
        bodies=found.bodies,
        coordinate_names=(),
        t=phase / (2 * np.pi) * period,
        q=q,
        v=v,
        a=0 * v,
        lam=empty,
        violation=np.zeros(FRAMES),
        system=system,
    )
    options: dict[str, Any] = {"reactions": [], "forces": False, "speed": period / LASTS}
    return animate(run, file, labels=[title], count=FRAMES, **options)


def _swing(q: Array, shape: Array, phase: Array) -> Array:
    """Positions along the mode, Euler parameters at unit length."""
    out = q + np.real(shape * np.exp(1j * phase)[:, None])
    for at in range(3, len(q), 7):
        out[:, at : at + 4] /= np.linalg.norm(out[:, at : at + 4], axis=1, keepdims=True)
    return np.asarray(out)


def _rates(shape: Array, phase: Array, rate: float) -> Array:
    return np.asarray(np.real(1j * rate * shape * np.exp(1j * phase)[:, None]))
