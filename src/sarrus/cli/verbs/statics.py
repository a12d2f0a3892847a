"""``sarrus statics MODEL``: the equilibrium of a mechanism, and its joint reactions."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from .. import model_file, shared
from ..answer import Answer
from ..motion import note_shared, without_round_off

if TYPE_CHECKING:
    from ...results import Equilibrium
    from ...system import System

PURPOSE = "find an equilibrium of a model file, with its stability and joint reactions"
EXAMPLES = ("sarrus statics crank.yaml", "sarrus statics crank.yaml --nearest --json")


def arguments(parser: argparse.ArgumentParser) -> None:
    """The model file, and which equilibrium is wanted."""
    model_file.arguments(parser)
    shared.rest(parser)


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Print the equilibrium, its poses and reactions; 1 if there is none."""
    from ...analyses import equilibrium
    from ...system import System

    system = System(model_file.read(chosen, answer))
    found = equilibrium(system, t=chosen.time, stable=not chosen.nearest)
    answer.show(found.message)
    answer.put(model=system.name, message=found.message, stability=found.stability)
    answer.put(bodies=_poses(system, found, answer))
    answer.put(reactions=_reactions(system, found, chosen.time, answer) if found.success else {})
    if found.success:
        note_shared(system, found, answer)
    return 0 if found.success else 1


def _poses(system: System, found: Equilibrium, answer: Answer) -> dict[str, Any]:
    poses = {}
    for body in system.bodies:
        pose = found.q[system.coordinates_of(body)]
        x, y, z = pose[:3]
        answer.show(f"  {body:<24} x = {x:+.9f}  y = {y:+.9f}  z = {z:+.9f} m")
        poses[body] = {"position": pose[:3], "euler": pose[3:]}
    return poses


def _reactions(system: System, found: Equilibrium, t: float, answer: Answer) -> dict[str, Any]:
    import numpy as np

    reactions = {}
    for joint in system.rows:
        action = system.reaction(joint, found.q, found.lam, t)
        force, torque = (float(np.linalg.norm(x)) for x in (action.force, action.torque))
        shown = "  {:<24} force {:.6g} N, torque {:.6g} N m"
        answer.show(shown.format(joint, *without_round_off(force, torque)))
        reactions[joint] = {"force": action.force, "torque": action.torque}
    return reactions
