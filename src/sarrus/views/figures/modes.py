"""Vibration modes as a table and in the complex plane."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...results import Modes
from .style import BLUE, GREY, ORANGE, plot_axes

SHOWN = 3  # bodies named per mode
NOTICED = 0.05  # of the largest share


def modes_table(found: Modes) -> str:
    """One line per mode: eigenvalue, frequency, damping ratio, and the bodies that move most.

    Up to three bodies are named, those with the largest parts of the kinetic energy; ``free`` is a motion that
    nothing brings back.

    Parameters
    ----------
    found : Modes

    Returns
    -------
    str
    """
    lines = [f"{'mode':>4}{'eigenvalue [1/s]':>28}{'frequency [Hz]':>16}{'damping':>9}  moves most"]
    for mode, eigenvalue, frequency, damping, moving in mode_rows(found):
        lines.append(f"{mode:>4}{eigenvalue:>28}{frequency:>16}{damping:>9}  {moving}")
    return "\n".join([*lines, found.message])


def mode_rows(found: Modes) -> list[tuple[str, ...]]:
    """Number, eigenvalue, frequency and damping ratio of each mode, and the bodies that move most, as text."""
    values = zip(found.eigenvalues, found.frequencies, found.damping_ratios, strict=True)
    return [
        (
            str(n),
            _number(s),
            f"{frequency:.6g}",
            "free" if s == 0 else f"{ratio:.4f}",
            ", ".join(_moving(found, n)),
        )
        for n, (s, frequency, ratio) in enumerate(values)
    ]


def _number(s: complex) -> str:
    return f"{s.real + 0.0:+.6g}" + (f" ± {s.imag:.6g} i" if s.imag else "")


def _moving(found: Modes, mode: int) -> list[str]:
    """Bodies by kinetic energy."""
    share = found.energy_shares[:, mode]
    order = np.argsort(-share, kind="stable")[:SHOWN]
    return [found.bodies[n] for n in order if share[n] > NOTICED * share.max(initial=0.0)]


def plot_modes(found: Modes, ax: Any = None) -> Any:
    """Draw the eigenvalues in the upper half of the complex plane; those of growing motions stand out.

    Left of the axis motions decay, the faster the farther; on it they go on for ever. A pair that has met the real
    axis no longer oscillates.

    Parameters
    ----------
    found : Modes
    ax : Matplotlib axes to draw into; by default a new figure's

    Returns
    -------
    Axes

    Raises
    ------
    ImportError
        If Matplotlib is not installed.
    """
    ax = plot_axes(ax)
    decay, frequency = found.eigenvalues.real, found.frequencies
    free, grows = found.eigenvalues == 0, decay > found.round_off
    for chosen, colour, label in ((grows, ORANGE, "grows"), (free, GREY, "free"), (~grows & ~free, BLUE, "")):
        if np.any(chosen):
            ax.scatter(decay[chosen], frequency[chosen], color=colour, label=label or None, s=26, zorder=3)
    if np.any(free | grows):
        ax.legend(frameon=False, ncols=2, loc="lower right", bbox_to_anchor=(1, 1))
    ax.axvline(0.0, color=GREY, linewidth=0.8)
    ax.set(xlabel="decay (left) or growth (right), Re s [1/s]", ylabel="damped frequency [Hz]")
    ax.set_title(f"{found.name}: eigenvalues of the vibration modes", loc="left", fontsize=10)
    return ax
