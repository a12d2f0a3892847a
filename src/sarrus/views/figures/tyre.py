"""Diagrams of a tyre: forces and aligning moment over the slips at several loads, and the forces in combined slip."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...algebra import Array
from ...elements.forces.tyres import Slip, TyreLaw, sampled
from ...model.checks.arguments import Number
from ...model.errors import ModelError
from ...model.show import show
from .style import legend_beside, new_figure, tidied

POINTS = 161
LOADS = (0.5, 1.0, 1.5)  # over the nominal load
LARGEST_KAPPA, LARGEST_ALPHA = 0.3, 15.0  # [-], [deg] of the axes
ANGLES = (1.0, 2.0, 4.0, 8.0)  # [deg] of the curves in combined slip
KILO = 1e-3


def tyre_figure(law: Any, name: str = "", load: float | None = None) -> Any:
    """Draw F_x over κ, F_y and M_z over α at three loads, and F_y over F_x at several slip angles.

    Parameters
    ----------
    law : of a tyre; or what has one as its ``law()``, a tyre or a `TyreFile`
    name : in the title
    load : the middle one of the loads [N]; by default the nominal load of the law, or 4000 N

    Returns
    -------
    Figure

    Raises
    ------
    ModelError
        If the load is not greater than 0, or there is no law.
    """
    if not isinstance(law, TyreLaw):
        law = _law_of(law)
    load = float(getattr(law, "nominal_load", 4000.0)) if load is None else load
    Number(positive=True)("load", load)
    figure = new_figure(9.8, 6.4)
    axes = [tidied(ax) for ax in np.ravel(figure.subplots(2, 2))]
    kappa, alpha = (np.linspace(-x, x, POINTS) for x in (LARGEST_KAPPA, LARGEST_ALPHA))
    for factor in LOADS:
        label = f"{factor * load * KILO:.3g} kN"
        along, side = forces(law, kappa, 0.0, factor * load), forces(law, 0.0, alpha, factor * load)
        axes[0].plot(kappa, along[:, 0] * KILO, label=label)
        axes[1].plot(alpha, side[:, 1] * KILO, label=label)
        axes[2].plot(alpha, side[:, 2], label=label)
    wide = np.linspace(-0.99, 1.0, 4 * POINTS)
    for angle in ANGLES:
        both = forces(law, wide, -angle, load) * KILO
        axes[3].plot(both[:, 0], both[:, 1], label=f"α = -{angle:g}°")
    titles = (
        ("κ", "$F_x$ [kN]"),
        ("α [deg]", "$F_y$ [kN]"),
        ("α [deg]", "$M_z$ [N m]"),
        ("$F_x$ [kN]", "$F_y$ [kN]"),
    )
    for ax, (across, up) in zip(axes, titles, strict=True):
        ax.set(xlabel=across, ylabel=up)
    axes[0].legend(frameon=False, title="$F_z$", loc="upper left")
    legend_beside(axes[3], True, title=f"$F_z$ = {load * KILO:.3g} kN")
    figure.suptitle(name)
    return figure


def _law_of(tyre: Any) -> TyreLaw:
    found = tyre.law() if callable(getattr(tyre, "law", None)) else None
    if not isinstance(found, TyreLaw):
        raise ModelError(
            f"law must be that of a tyre, but is {show(tyre)}. Give a tyre, a TyreFile or a law."
        )
    return found


def forces(law: TyreLaw, kappa: Any, alpha: Any, load: float, gamma: float = 0.0) -> Array:
    """F_x, F_y [N] and M_z [N m] at longitudinal slips and slip angles [deg], which a law may limit (n, 3)."""
    values, _ = sampled(law, Slip(kappa, np.tan(np.radians(alpha)), gamma, load))
    return np.asarray(values[[0, 1, 4]].T)
