"""A fitted simulation over its measurements."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np

from ...outputs import UnknownOutput
from ...outputs.output import labelled
from .style import BLUE, ORANGE, over_time, panels

if TYPE_CHECKING:
    from ...results import Optimum
    from ...results.optimum import Fitted

MANY = 200  # measurements, beyond which dots are small


def plot_fit(optimum: Optimum, ax: Any = None) -> Any:
    """Draw measurements with their standard deviations, and the fitted simulation, over time.

    Parameters
    ----------
    optimum : result of `fit`
    ax : Matplotlib axes to draw into, one for each measured output, or a figure; by default a new figure's

    Returns
    -------
    Axes, or an array of them for several measured outputs

    Raises
    ------
    ValueError
        If no measurements were fitted.
    ImportError
        If Matplotlib is not installed.
    """
    if not optimum.measurements:
        raise ValueError("plot_fit: nothing was measured. Use plot() for the convergence of an optimization.")
    axes = panels(ax, len(optimum.measurements), 2.6)
    for panel, measured in zip(axes, optimum.measurements, strict=True):
        size = 3.0 if len(measured.t) < MANY else 1.5
        data = {"fmt": "o", "color": ORANGE, "markersize": size, "elinewidth": 0.8, "label": "measured"}
        panel.errorbar(measured.t, measured.data, yerr=measured.sigma, zorder=1, **data)
        panel.plot(*_curve(optimum, measured), color=BLUE, linewidth=1.4, label="fitted", zorder=2)
        panel.set_ylabel(labelled(measured.output, measured.unit))
        rms = float(np.sqrt(np.mean((measured.values - measured.data) ** 2)))
        text = f"residual {rms:.3g} {measured.unit}".rstrip()
        panel.set_title(f"{text} rms, sigma {measured.sigma:.3g}", fontsize="small", loc="left")
    axes[0].legend(frameon=False, ncols=2, loc="lower right", bbox_to_anchor=(1, 1), borderaxespad=0.2)
    return over_time(axes)


def _curve(optimum: Optimum, measured: Fitted) -> tuple[Any, Any]:
    """The output of the fitted run, if it has a name; else its values at the times of the measurements."""
    if optimum.run is not None:
        with suppress(UnknownOutput):
            return optimum.run.t, optimum.run.output(measured.output).values
    order = np.argsort(measured.t)
    return measured.t[order], measured.values[order]
