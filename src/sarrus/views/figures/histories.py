"""A run over time and in the phase plane: coordinates, angles and displacements, energies, violation, step sizes."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ...algebra import Array
from ...outputs.output import labelled
from ...outputs.units import quotient
from ...results import Reaction, Trajectory
from .style import (
    BLUE,
    GREY,
    ORANGE,
    in_two_lines,
    legend_beside,
    over_time,
    panels,
    plot_axes,
    suppress_round_off,
)

if TYPE_CHECKING:
    from ...results import EnergyBalance, StateDerivatives

FORCES = ("N", "N m")  # units of what multipliers make
ZERO = float(np.finfo(float).eps)  # shown in place of a violation of exactly zero
PARTS = 60  # of a run, whose largest violations are drawn


def plot(run: Trajectory, *names: str, ax: Any = None, rates: bool = False, over: str | None = None) -> Any:
    """Draw outputs over time, or over another output.

    Parameters
    ----------
    run : Trajectory
    names : of outputs, ``"slider.x"``, ``"pin.angle"``, ``"spring.tension"``, or of vectors, ``"pin.force"``; by
        default the x of the last body
    ax : Matplotlib axes to draw into, one for each unit, or a figure; by default a new figure's
    rates : whether their rates are drawn
    over : output of the horizontal axis instead of the time: the path of a point is
        ``plot("rod(0.1, 0, 0).y", over="rod(0.1, 0, 0).x")``. Two lengths have the same scale

    Returns
    -------
    Axes, or an array of them for several units

    Raises
    ------
    KeyError
        For an unknown output.
    ImportError
        If Matplotlib is not installed.
    """
    every = [one for name in names or (f"{run.bodies[-1]}.x",) for one in run.components(name)]
    outputs = [run.output(name, rate=rates) for name in every]
    below = None if over is None else run.output(over)
    x = run.t if below is None else below.values
    units = list(dict.fromkeys(one.unit for one in outputs))
    axes = panels(ax, len(units))
    scale = max(1.0, float(np.max(abs(np.asarray(run.lam)), initial=0.0)))
    for one, unit in zip(axes, units, strict=True):
        curves = [curve for curve in outputs if curve.unit == unit]
        for curve in curves:
            one.plot(x, curve.values, linewidth=1.4, label=curve.name)
        label = curves[0].label if len(curves) == 1 else f"[{unit}]" if unit else ""
        one.set_ylabel(in_two_lines(label) if len(units) > 1 else label)
        if len(curves) > 1:
            legend_beside(one, ax is None)
        if below and unit == below.unit == "m":
            one.set_aspect("equal", adjustable="datalim")
        largest = max(float(np.max(abs(curve.values), initial=0.0)) for curve in curves)
        suppress_round_off(one, largest, scale if unit in FORCES else 1e-3, unit)
    return over_time(axes, "t [s]" if below is None else below.label)


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
    output, rate = run.output(name), run.output(name, rate=True)
    if isinstance(ax, str):
        raise TypeError(
            f"plot_phase draws the rate of one output over it. Draw another over it by plot({ax!r}, over={name!r})."
        )
    ax = plot_axes(ax)
    ax.plot(output.values, rate.values, color=BLUE, linewidth=1.2)
    ax.plot(output.values[:1], rate.values[:1], "o", color=ORANGE, markersize=5, label="start")
    ax.set(xlabel=output.label, ylabel=rate.label)
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
    ax.legend(frameon=False, loc="center left", bbox_to_anchor=(1, 0.5))
    return ax


def plot_energy_balance(balance: EnergyBalance, ax: Any = None) -> Any:
    """Draw stored, dissipated and supplied energies over time, by part, and their total, which is constant.

    Parameters
    ----------
    balance : EnergyBalance
    ax : Matplotlib axes to draw into; by default a new figure's

    Returns
    -------
    Axes

    Raises
    ------
    ImportError
        If Matplotlib is not installed.
    """
    ax = plot_axes(ax, 7.0, 4.2)
    stored = {"kinetic": balance.kinetic, "potential": balance.potential, "elastic": balance.elastic}
    dissipated = {f"dissipated: {name}": energy for name, energy in balance.dissipated.items()}
    supplied = {f"supplied: {name}": energy for name, energy in balance.supplied.items()}
    groups = ((stored, "-"), (dissipated | {"impacts": balance.impacts}, "--"), (supplied, ":"))
    for energies, style in groups:
        for label, energy in energies.items():
            if np.any(energy):
                ax.plot(balance.t, energy, style, linewidth=1.3, label=label)
    ax.plot(balance.t, balance.total, color="black", linewidth=1.8, label="total")
    ax.set(xlabel="t [s]", ylabel="energy [J]")
    ax.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5))
    return ax


def plot_violation(run: Trajectory, ax: Any = None) -> Any:
    """Draw the envelope of constraint violations over time, logarithmic: positions, and velocities if known.

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
    known = [(run.violation, BLUE, "|Φ|", "[m] or [1]")]
    if len(run.velocity_violation) == len(run.t):
        known.append((run.velocity_violation, ORANGE, "|Φ_q v + Φ_t|", "[m/s] or [1/s]"))
    axes = panels(ax, len(known))
    for one, (values, colour, label, unit) in zip(axes, known, strict=True):
        t, largest = _envelope(np.asarray(run.t), np.maximum(values, ZERO))
        one.fill_between(t, ZERO, largest, color=colour, alpha=0.15, linewidth=0)
        one.semilogy(t, largest, color=colour, linewidth=1.2, label=label)
        one.set(ylabel=f"{label} {unit}", ylim=(ZERO, None))
    return over_time(axes)


def _envelope(t: Array, values: Array) -> tuple[Array, Array]:
    """The largest values of parts of a run, at most `PARTS`, each at the ends of its part."""
    if len(t) <= 2 * PARTS:
        return t, values
    cuts = np.linspace(0, len(t) - 1, PARTS + 1).astype(int)
    largest = np.array([values[a : b + 1].max() for a, b in pairwise(cuts)])
    return np.column_stack([t[cuts[:-1]], t[cuts[1:]]]).ravel(), np.repeat(largest, 2)


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
    derivatives: StateDerivatives, run: Trajectory, output: str, ax: Any = None, *, most: int = 8
) -> Any:
    """Draw the derivatives of an output over time, with respect to the parameters of the largest influence.

    Those of an output that oscillates grow with time wherever a parameter changes the frequency: what is seen then is a
    shift of phase, not of size.

    Parameters
    ----------
    derivatives : StateDerivatives
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
    unit, curves = run.output(output).unit, derivatives.output(output)
    sizes = abs(curves).max(axis=0)
    chosen = [k for k in np.argsort(-sizes, kind="stable")[:most] if sizes[k] > 0]
    by = {k: quotient(unit, derivatives.units[k]) if derivatives.units else "" for k in chosen}
    units = list(dict.fromkeys(by.values())) or [""]
    axes = panels(ax, len(units))
    for one, panel_unit in zip(axes, units, strict=True):
        for k in (k for k in chosen if by[k] == panel_unit):
            one.plot(derivatives.t, curves[:, k], linewidth=1.3, label=derivatives.names[k])
        one.set_ylabel(labelled(f"derivative of {output}", panel_unit))
        one.legend(frameon=False)
    return over_time(axes)


def plot_reaction(reaction: Reaction, ax: Any = None) -> Any:
    """Draw force and torque in global axes, as they act on the second body of a joint at its point.

    A force or torque that is round-off of the other is stated as a bound. `Reaction.joint_force` and
    `Reaction.joint_torque` have the components along the joint's own axes.

    Parameters
    ----------
    reaction : Reaction
    ax : two Matplotlib axes to draw into, or a figure; by default a new figure's

    Returns
    -------
    The two axes

    Raises
    ------
    ImportError
        If Matplotlib is not installed.
    """
    axes = panels(ax, 2)
    curves = {"force [N]": reaction.force, "torque [N m]": reaction.torque}
    scale = max(float(np.max(abs(values), initial=0.0)) for values in curves.values())
    for one, (label, values) in zip(axes, curves.items(), strict=True):
        for curve, name, colour in zip(values.T, "xyz", (BLUE, ORANGE, GREY), strict=True):
            one.plot(reaction.t, curve, linewidth=1.4, label=name, color=colour)
        one.set_ylabel(label)
        largest = float(np.max(abs(values), initial=0.0))
        suppress_round_off(one, largest, scale, label.partition("[")[2].strip("]"))
    axes[0].set_title(f"{reaction.joint}: on its second body, in global axes", loc="left", fontsize=10)
    axes[0].legend(frameon=False, ncols=3, loc="lower right", bbox_to_anchor=(1, 1))
    return over_time(axes)
