"""Reactions of a joint or driver over time."""

from __future__ import annotations

from typing import Any

from ..results import Reaction
from .plots import BLUE, GREY, ORANGE, _tidy, figure_of


def plot_reaction(found: Reaction, axes: Any = None) -> Any:
    """Draw force and torque along the joint's axes f, g, h, as they act on its second body.

    h is the axis of a hinge or slide, so the force along it is a thrust, and the torque about it that of a driver: an
    ideal hinge has none.

    Parameters
    ----------
    found : Reaction
    axes : two Matplotlib axes to draw into; by default a new figure's

    Returns
    -------
    Figure

    Raises
    ------
    ImportError
        If Matplotlib is not installed.
    """
    axes = figure_of(7.5, 4.6).subplots(2, 1, sharex=True) if axes is None else axes
    curves = {"force [N]": found.joint_force, "torque [N m]": found.joint_torque}
    for ax, (label, values) in zip(axes, curves.items(), strict=True):
        for curve, name, colour in zip(values.T, "fgh", (BLUE, ORANGE, GREY), strict=True):
            ax.plot(found.t, curve, linewidth=1.4, label=name, color=colour)
        _tidy(ax).set_ylabel(label)
    axes[0].set_title(f"{found.joint}: on its second body, along the joint's axes", loc="left", fontsize=10)
    axes[0].legend(frameon=False, ncols=3, loc="lower right", bbox_to_anchor=(1, 1))
    axes[1].set_xlabel("t [s]")
    return axes[0].figure
