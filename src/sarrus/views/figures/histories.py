"""A run over time and in the phase plane: coordinates, angles and displacements, energies, violation, step sizes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...outputs.output import labelled
from ...outputs.units import quotient
from ...results import Reaction, Trajectory
from .style import BLUE, GREY, ORANGE, figure_of, plot_axes, tidied

if TYPE_CHECKING:
    from ...results import StateDerivatives

FLOOR = 1e-17  # shown in place of a violation of exactly zero


def plot(run: Trajectory, *names: str, ax: Any = None, rates: bool = False) -> Any:
    """Draw outputs over time.

    Parameters
    ----------
    run : Trajectory
    names : of outputs, ``"slider.x"``, ``"pin.angle"``, ``"spring.tension"``; by default the x of the last body
    ax : Matplotlib axes to draw into; by default a new figure's
    rates : whether their rates are drawn

    Returns
    -------
    Axes

    Raises
    ------
    KeyError
        For an unknown output.
    ImportError
        If Matplotlib is not installed.
    """
    found = [run.output(name, rate=rates) for name in names or (f"{run.bodies[-1]}.x",)]
    ax = plot_axes(ax)
    for one in found:
        ax.plot(run.t, one.values, linewidth=1.4, label=one.name)
    ax.set_xlabel("t [s]")
    units = dict.fromkeys(f"[{one.unit}]" for one in found)
    ax.set_ylabel(found[0].label if len(found) == 1 else ", ".join(units))
    if len(names) > 1:
        ax.legend(frameon=False)
    return ax


def plot_phase(run: Trajectory, name: str, ax: Any = None) -> Any:
    """Draw the rate of an output over the output, with the start as a dot.

    A periodic motion closes, a damped one winds inwards to its rest, and a stop or impact shows as a jump straight down
    or up.

    Parameters
    ----------
    run : Trajectory
    name : of an output of positions and velocities, ``"slider.x"``, ``"pin.angle"``, ``"spring.length"``
    ax : Matplotlib axes to draw into; by default a new figure's

    Returns
    -------
    Axes

    Raises
    ------
    KeyError
        For an unknown output.
    ImportError
        If Matplotlib is not installed.
    """
    found, rate = run.output(name), run.output(name, rate=True)
    ax = plot_axes(ax)
    ax.plot(found.values, rate.values, color=BLUE, linewidth=1.2)
    ax.plot(found.values[:1], rate.values[:1], "o", color=ORANGE, markersize=5, label="start")
    ax.set(xlabel=found.label, ylabel=rate.label)
    ax.legend(frameon=False)
    return ax


def plot_energies(run: Trajectory, ax: Any = None) -> Any:
    """Draw kinetic, potential and total energy over time.

    The potential is that of gravity, springs and bushings. Without other forces, dampers and drivers the total
    is a level line: its drift is the error of the method, or its numerical damping. What other forces do is seen as a
    change of the total.

    Parameters
    ----------
    run : Trajectory
    ax : Matplotlib axes to draw into; by default a new figure's

    Returns
    -------
    Axes

    Raises
    ------
    ValueError
        If the run was made without energies.
    ImportError
        If Matplotlib is not installed.
    """
    if len(run.kinetic_energy) != len(run.t):
        raise ValueError(f"{run.name}: this trajectory was made without energies. Use simulate.")
    ax = plot_axes(ax)
    ax.plot(run.t, run.kinetic_energy, color=ORANGE, linewidth=1.2, label="kinetic")
    ax.plot(run.t, run.potential_energy, color=GREY, linewidth=1.2, label="potential")
    ax.plot(run.t, run.total_energy, color=BLUE, linewidth=1.8, label="total")
    ax.set(xlabel="t [s]", ylabel="energy [J]")
    ax.legend(frameon=False)
    return ax


def plot_violation(run: Trajectory, ax: Any = None) -> Any:
    """Draw how far constraints are violated over time, on a logarithmic scale: positions, and velocities if known.

    A method that solves the index-3 equations keeps positions to its tolerance and lets velocities be off by more; the
    stabilized ones and those that project keep both. An increasing curve shows that the run is unreliable there.

    Parameters
    ----------
    run : Trajectory
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
    ax.semilogy(run.t, np.maximum(run.violation, FLOOR), color=BLUE, linewidth=1.0, label="|Φ|")
    if len(run.velocity_violation) == len(run.t):
        rates = np.maximum(run.velocity_violation, FLOOR)
        ax.semilogy(run.t, rates, color=ORANGE, linewidth=1.0, label="|Φ_q v + Φ_t|")
    ax.set(xlabel="t [s]", ylabel="largest violation [m], [1]; [m/s], [1/s]")
    ax.legend(frameon=False)
    return ax


def plot_steps(run: Trajectory, ax: Any = None) -> Any:
    """Draw the size of every accepted step over time, on a logarithmic scale.

    If it decreases by orders of magnitude, a force is stiff or jumps, or the mechanism passes a singular configuration.
    The title has the number of rejected steps.

    Parameters
    ----------
    run : Trajectory
    ax : Matplotlib axes to draw into; by default a new figure's

    Returns
    -------
    Axes

    Raises
    ------
    ValueError
        If the run has no steps, as one of kinematics.
    ImportError
        If Matplotlib is not installed.
    """
    if not len(run.history):
        raise ValueError(f"{run.name}: this trajectory was not made by steps. Use simulate.")
    ax = plot_axes(ax)
    ends, lengths = run.history[:, 0], run.history[:, 1]
    ax.step(ends, lengths, where="pre", color=BLUE, linewidth=1.1)
    ax.set_yscale("log")
    ax.set(xlabel="t [s]", ylabel="step length [s]")
    ax.set_title(f"{run.nsteps} steps, {run.nrejected} rejected", loc="left", fontsize=10)
    return ax


def plot_sensitivities(
    found: StateDerivatives, run: Trajectory, output: str, ax: Any = None, *, most: int = 8
) -> Any:
    """Draw the derivatives of an output over time, with respect to the parameters of the largest influence.

    Those of an output that oscillates grow with time wherever a parameter changes the frequency: what is seen then is a
    shift of phase, not of size.

    Parameters
    ----------
    found : StateDerivatives
    run : the run that was differentiated
    output : its name, ``"slider.x"``, ``"spring.tension"``
    ax : Matplotlib axes to draw into; by default a new figure's
    most : of how many parameters

    Returns
    -------
    Axes

    Raises
    ------
    KeyError
        For an unknown output.
    ImportError
        If Matplotlib is not installed.
    """
    unit, curves = run.output(output).unit, found.output(output)
    sizes = abs(curves).max(axis=0)
    ax = plot_axes(ax)
    for k in np.argsort(-sizes, kind="stable")[:most]:
        if sizes[k] > 0:
            by = quotient(unit, found.units[k]) if found.units else ""
            ax.plot(found.t, curves[:, k], linewidth=1.3, label=labelled(found.names[k], by))
    ax.set(xlabel="t [s]", ylabel=f"derivative of {output} by")
    ax.legend(frameon=False)
    return ax


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
        tidied(ax).set_ylabel(label)
    axes[0].set_title(f"{found.joint}: on its second body, along the joint's axes", loc="left", fontsize=10)
    axes[0].legend(frameon=False, ncols=3, loc="lower right", bbox_to_anchor=(1, 1))
    axes[1].set_xlabel("t [s]")
    return axes[0].figure
