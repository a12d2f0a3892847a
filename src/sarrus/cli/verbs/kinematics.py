"""``sarrus kinematics MODEL``: the motion that the drivers prescribe, and the forces that it takes."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from .. import model_file, shared
from ..answer import Answer, named
from ..motion import note_shared, wanted_outputs, without_round_off, write
from ..progress import Bar
from ..values import refuse_unwritable

if TYPE_CHECKING:
    from ...results import Trajectory

PURPOSE = "compute the motion that the drivers of a model file prescribe, and its forces"
EXAMPLES = (
    "sarrus kinematics press.yaml --until 2 --steps 400",
    "sarrus kinematics press.yaml --plot motor.torque.x ram.z --figure motor.svg --csv press.csv",
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """The model file, the times, and what to write."""
    model_file.arguments(parser)
    shared.times(parser)
    shared.time_limit(parser)
    shared.motion_table(parser)
    drawn = parser.add_mutually_exclusive_group()
    shared.plot(drawn)
    drawn.add_argument("--reaction", metavar="NAME", help="a joint or driver: its force and torque are drawn")
    shared.figure(parser, "the plot", "kinematics.png")


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Follow the drivers; 1 if they lead nowhere (what was reached is still written)."""
    import numpy as np

    from ...analyses import kinematics
    from ...model.errors import SarrusError
    from ...system import System

    refuse_unwritable([chosen.csv, chosen.figure if chosen.reaction or chosen.plot else None])
    system = System(model_file.read(chosen, answer))
    if chosen.reaction and chosen.reaction not in system.rows:
        raise SarrusError(f"no joint or driver {chosen.reaction!r}. Choose from {', '.join(system.rows)}.")
    wanted_outputs(chosen, system)
    with Bar(f"following the drivers for {chosen.until:g} s", chosen.until) as bar:
        times, limit = np.linspace(0.0, chosen.until, chosen.steps + 1), chosen.time_limit
        motion = kinematics(system, times, progress=bar.reach, time_limit=limit)
    answer.show(named(system.name, motion.message))
    answer.put(model=system.name, status=motion.status, message=motion.message)
    answer.put(t=motion.t[-1] if len(motion.t) else None, reactions=_reactions(motion, answer))
    note_shared(system, motion, answer)
    write(chosen, motion, answer)
    if chosen.reaction and len(motion.t):
        answer.draw(motion.reaction(chosen.reaction).plot()[0].figure, chosen.figure)
    return 0 if motion.success else 1


def _reactions(motion: Trajectory, answer: Answer) -> dict[str, dict[str, float]]:
    """The largest force and torque of every joint and driver."""
    import numpy as np

    largest = {}
    for joint in motion.system.rows if motion.system and len(motion.t) else ():
        found = motion.reaction(joint)
        force, torque = (float(np.linalg.norm(x, axis=1).max()) for x in (found.force, found.torque))
        shown = "  {:<24} force up to {:.6g} N, torque up to {:.6g} N m"
        answer.show(shown.format(joint, *without_round_off(force, torque)))
        largest[joint] = {"largest_force": force, "largest_torque": torque}
    return largest
