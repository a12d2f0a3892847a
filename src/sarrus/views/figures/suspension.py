"""The sheet of a suspension: its characteristics over bump, roll or steer."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np

from ...model.errors import SarrusError
from .style import BLUE, INCHES, ORANGE, in_two_lines, new_figure, tidied

if TYPE_CHECKING:
    from ...vehicles import Suspension
    from ...vehicles.characteristics import SweepName

SHEETS = {
    "bump": "toe camber caster kingpin_inclination scrub_radius mechanical_trail track_change wheel_recession "
    "roll_centre_height fvsa_angle svsa_angle anti_dive spring_ratio",
    "roll": "roll_angle toe camber caster roll_centre_height roll_centre_lateral",
    "steer": "steer_angle camber caster_trail scrub_radius ackermann_angle ackermann_error turn_radius",
}
COLUMNS = 3  # of a sheet, or so many more that no panel is alone in its row
OF_AXLE = ("roll_centre_height", "roll_centre_lateral", "roll_angle", "ackermann_angle")
FARTHEST = 100.0  # [m] the largest radius of a turn that is drawn


def plot_suspension(result: Suspension, sweep: SweepName, names: Sequence[str] = (), ax: Any = None) -> Any:
    """Draw characteristics over the displacement of a sweep, the left and the right wheel in one panel.

    Parameters
    ----------
    result : Suspension
    sweep : bump, roll, steer or kingpin
    names : of characteristics; by default the usual sheet of the sweep
    ax : as many Matplotlib axes, or a figure; by default a new one

    Returns
    -------
    Array of axes
    """
    from ...vehicles.tables import SHOWN, column, displacement

    known = result.names(sweep)
    sheet = SHEETS[sweep].split() if sweep in SHEETS else known
    names = names or [name for name in sheet if name in known]
    columns = next((n for n in range(COLUMNS, len(names)) if len(names) % n != 1), len(names))
    axes, x = _axes(ax, len(names), columns), displacement(result, sweep)
    for one, name in zip(axes, names, strict=True):
        for side, (colour, line) in zip(result.sides, ((BLUE, "-"), (ORANGE, "--")), strict=False):
            if side == result.sides[0] or name not in OF_AXLE:
                shown = column(result, name, sweep, side)
                far = name.startswith("turn") & (abs(shown.values) * SHOWN["m"].size > FARTHEST)
                one.plot(x.values, np.where(far, np.nan, shown.values), line, color=colour, label=side)
                label = f"{name.replace('_', ' ')} [{shown.unit or 1}]"
        one.set_ylabel(in_two_lines(label))
        _keep_round_off_flat(one)
    for one in axes[-columns:]:
        one.set_xlabel(x.label)
        one.tick_params(labelbottom=True)
    if len(result.sides) > 1:
        axes[0].legend()
    return axes


def _keep_round_off_flat(axes: Any) -> None:
    """Limits of a quantity that does not change, so that round-off is not drawn at full height."""
    low, high = axes.get_ylim()
    middle = 0.5 * (low + high)
    if high - low < 1e-6:
        axes.set_ylim(middle - 1, middle + 1)


def _axes(ax: Any, count: int, columns: int) -> Any:
    if ax is None or hasattr(ax, "subplots"):
        rows = ceil(count / columns)
        figure = new_figure(INCHES.panel * 1.2 * columns, 2.1 * rows) if ax is None else ax
        every = np.ravel(figure.subplots(rows, columns, sharex=True))
        for empty in every[count:]:
            empty.remove()
        ax = every[:count]
    axes = np.atleast_1d(np.asarray(ax, dtype=object))
    if len(axes) != count:
        raise SarrusError(f"ax: {len(axes)} axes for {count} panels. Give {count} axes, or a figure.")
    return np.array([tidied(one) for one in axes], dtype=object)
