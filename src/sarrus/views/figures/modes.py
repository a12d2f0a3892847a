"""Vibration modes as a table and in the complex plane."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...algebra import Array
from ...model.errors import SHOWN
from ...results import Modes
from .style import BARS, BLUE, GREY, ORANGE, new_figure, tidied

NOTICED = 0.05  # of the largest share
MODES = 15  # whose participation is drawn


def modes_table(modes: Modes) -> str:
    """Return one line for each mode: eigenvalue, frequency, damping ratio, and the bodies that move most.

    The first mode is mode 1, as in the names of outputs, ``mode1.frequency``. Up to three bodies are named, those with
    the largest parts of the kinetic energy; ``free`` is a motion that nothing brings back.

    Parameters
    ----------
    modes : Modes

    Returns
    -------
    str
    """
    lines = [f"{'mode':>4}{'eigenvalue [1/s]':>28}{'frequency [Hz]':>16}{'damping':>9}  moves most"]
    for mode, eigenvalue, frequency, damping, moving in mode_rows(modes):
        lines.append(f"{mode:>4}{eigenvalue:>28}{frequency:>16}{damping:>9}  {moving}")
    return "\n".join([*lines, modes.message])


def mode_rows(modes: Modes) -> list[tuple[str, ...]]:
    """Number from 1, eigenvalue, frequency and damping ratio of each mode, and the bodies that move most, as text."""
    rows = list[tuple[str, ...]]()
    values = zip(modes.eigenvalues, modes.frequencies, modes.damping_ratios, strict=True)
    for n, (s, frequency, ratio) in enumerate(values):
        damping = "free" if s == 0 else f"{ratio:.4f}"
        rows.append((str(n + 1), _number(s), f"{frequency:.6g}", damping, ", ".join(_moving(modes, n))))
    return rows


def _number(s: complex) -> str:
    return f"{s.real + 0.0:+.6g}" + (f" ± {s.imag:.6g} i" if s.imag else "")


def _moving(modes: Modes, mode: int) -> list[str]:
    """Bodies by kinetic energy; where none moves, first-order states by their changes in parts of their sizes."""
    share = modes.energy_shares[:, mode]
    if not share.any() and modes.system is not None:
        sizes = {
            name: float(abs(modes.shapes[state.place, mode])) / state.nominal
            for name, state in modes.system.states.items()
        }
        ordered = sorted(sizes, key=lambda name: -sizes[name])[:SHOWN]
        return [name for name in ordered if sizes[name] > NOTICED * max(sizes.values())]
    order = np.argsort(-share, kind="stable")[:SHOWN]
    return [modes.owners[n] for n in order if share[n] > NOTICED * share.max(initial=0.0)]


def plot_modes(modes: Modes, ax: Any = None) -> Any:
    """Draw the eigenvalues in the upper half of the complex plane, and the kinetic energy of each mode by body.

    Left of the axis motions decay, the faster the farther; on it they go on for ever. A pair that has met the real
    axis no longer oscillates.

    Parameters
    ----------
    modes : Modes
    ax : a figure or two Matplotlib axes to draw into, or one for the eigenvalues alone; by default a new figure

    Returns
    -------
    Axes, two unless one was given

    Raises
    ------
    ImportError
        If Matplotlib is not installed.
    """
    if ax is not None and hasattr(ax, "plot"):
        return _eigenvalues(modes, tidied(ax))
    ax = new_figure(11.0, 3.6) if ax is None else ax
    left, right = (ax.subplots(1, 2, width_ratios=(2, 3)) if hasattr(ax, "subplots") else ax)[:2]
    _eigenvalues(modes, tidied(left))
    _participation(modes, tidied(right))
    return np.array([left, right])


def mode_title(modes: Modes, mode: int) -> str:
    """Number from 1, frequency and damping ratio of a mode by its index."""
    if modes.eigenvalues[mode] == 0:
        return f"mode {mode + 1}, free"
    return (
        f"mode {mode + 1}, {modes.frequencies[mode]:.4g} Hz, damping ratio {modes.damping_ratios[mode]:.3g}"
    )


def _participation(modes: Modes, ax: Any) -> None:
    """The shares of the bodies in the kinetic energy of each mode, as bars on each other; oscillations come first."""
    chosen = np.sort(np.argsort(modes.frequencies == 0, kind="stable")[:MODES])
    shares = modes.energy_shares[:, chosen]
    places, below = np.arange(len(chosen)), np.zeros(len(chosen))
    large = [n for n, share in enumerate(shares) if np.any(share > NOTICED)]
    others = np.delete(shares, large, axis=0).sum(axis=0)
    parts: list[tuple[str, Array, str | None]] = [(modes.owners[n], shares[n], None) for n in large]
    parts += [("others", others, GREY)] * bool(others.any())
    for label, share, colour in parts:
        ax.bar(places, share, bottom=below, label=label, width=0.7, color=colour)
        below += share
    ratios = ["free" if modes.eigenvalues[n] == 0 else f"{modes.damping_ratios[n]:.2g}" for n in chosen]
    marks = [f"{n + 1}\n{modes.frequencies[n]:.3g}\n{ratio}" for n, ratio in zip(chosen, ratios, strict=True)]
    ax.set_xticks(places, marks, fontsize=7)
    ax.set_xlim(-0.5, max(len(chosen), BARS) - 0.5)
    label = "mode, damped frequency [Hz], damping ratio [1]"
    ax.set(xlabel=label, ylabel="share of the kinetic energy [1]", ylim=(0, 1.02))
    ax.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5))


def _eigenvalues(modes: Modes, ax: Any) -> Any:
    decay, frequency = modes.eigenvalues.real, modes.frequencies
    free, grows = modes.eigenvalues == 0, decay > modes.round_off
    for chosen, colour, label in ((grows, ORANGE, "grows"), (free, GREY, "free"), (~grows & ~free, BLUE, "")):
        if np.any(chosen):
            ax.scatter(decay[chosen], frequency[chosen], color=colour, label=label or None, s=26, zorder=3)
    if np.any(free | grows):
        ax.legend(frameon=False, loc="best")
    ax.axvline(0.0, color=GREY, linewidth=0.8)
    ax.set(xlabel="decay (left) or growth (right), Re s [1/s]", ylabel="damped frequency [Hz]")
    ax.set_ylim(-0.05 * (top := float(frequency.max(initial=0.0)) or 1.0), 1.1 * top)
    ax.set_title(f"{modes.name}: eigenvalues of the vibration modes", loc="left", fontsize=10)
    return ax
