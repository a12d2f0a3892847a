"""Outputs of a motion that a verb writes as a table and draws."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from .answer import Answer

ROUND_OFF = 1e-12  # [m], [1/m] of a reaction: its torque over its force, and the reverse

if TYPE_CHECKING:
    from ..outputs.output import Output
    from ..results import Equilibrium, Trajectory
    from ..system import System


def wanted_outputs(chosen: argparse.Namespace, system: System) -> list[Output]:
    """The outputs to draw and to write.

    Raises
    ------
    SarrusError
        For an output that is not there, before anything is computed.
    """
    from ..outputs import find_output
    from ..outputs.output import components
    from ..views.figures.style import figure_of

    if chosen.plot:
        figure_of(1, 1)  # Matplotlib is there
    names = (*(chosen.plot or ()), *chosen.columns)
    return [find_output(system, one) for name in names for one in components(system, name)]


def without_round_off(force: float, torque: float) -> tuple[float, float]:
    """Largest force and torque of a reaction, 0 where one is the round-off of the other."""
    return (force if force > ROUND_OFF * torque else 0.0), (torque if torque > ROUND_OFF * force else 0.0)


def note_shared(system: System, found: Equilibrium | Trajectory, answer: Answer) -> None:
    """Name below a table of all reactions which of them are shared by redundant joints."""
    from ..outputs.motion import reaction_outputs, shared_by, words_of

    shared = shared_by(found, [name for joint in system.rows for name in reaction_outputs(joint)])
    answer.put(shared=shared)
    if shared:
        answer.show(f"  reactions {words_of(shared).strip()}")


def write(chosen: argparse.Namespace, motion: Trajectory, answer: Answer) -> None:
    """Write the table and the figure that are asked for."""
    from ..views import plot
    from ..views.figures.style import figure_of

    if chosen.csv:
        motion.to_csv(chosen.csv, *chosen.columns)
        answer.wrote(chosen.csv)
    if chosen.plot and len(motion.t):
        units = {motion.output(one).unit for name in chosen.plot for one in motion.components(name)}
        figure = figure_of(7, max(3.2, 2.2 * len(units)))
        plot(motion, *chosen.plot, ax=figure)
        answer.draw(figure, chosen.figure)
