"""``sarrus kinematics MODEL``: the motion that the drivers prescribe, and the forces that it takes."""

from __future__ import annotations

import argparse
import sys

from .progress import Bar


def arguments(parser: argparse.ArgumentParser) -> None:
    """The model file, the times, and what to write."""
    parser.add_argument(
        "model", help="a .yaml or .json model file with as many drivers as degrees of freedom"
    )
    parser.add_argument("--until", type=float, default=1.0, help="end time [s] (1)")
    parser.add_argument("--steps", type=int, default=1000, help="output intervals (1000)")
    parser.add_argument("--csv", help="file for t, q and v as a table")
    parser.add_argument(
        "--reaction", metavar="NAME", help="a joint or driver: its force and torque are drawn"
    )
    parser.add_argument("--figure", default="reaction.png", help="file for that, .png or .svg (reaction.png)")


def run(chosen: argparse.Namespace) -> int:
    """Follow the drivers; 1 if they lead nowhere (what was reached is still written)."""
    import numpy as np

    from ..analyses import kinematics
    from ..model import load
    from ..model.errors import SarrusError
    from ..system import System

    if not chosen.until > 0 or chosen.steps < 1:
        raise SarrusError("--until must be a positive time and --steps at least 1")
    system = System(load(chosen.model))
    if chosen.reaction and chosen.reaction not in system.rows:
        raise SarrusError(f"no joint or driver {chosen.reaction!r}; there are {', '.join(system.rows)}")
    with Bar(f"following the drivers for {chosen.until:g} s", chosen.until) as bar:
        motion = kinematics(system, np.linspace(0.0, chosen.until, chosen.steps + 1), progress=bar.reach)
    print(f"{system.name}: {motion.message}")
    for joint in system.rows if len(motion.t) else ():
        found = motion.reaction(joint)
        force, torque = (float(np.linalg.norm(x, axis=1).max()) for x in (found.force, found.torque))
        print(f"  {joint:<24} force up to {force:.6g} N, torque up to {torque:.6g} N m")
    _write(chosen, motion)
    return 0 if motion.success else 1


def _write(chosen: argparse.Namespace, motion: object) -> None:
    from ..results import Trajectory

    assert isinstance(motion, Trajectory)
    if chosen.csv:
        motion.to_csv(chosen.csv)
        print(f"wrote {chosen.csv}", file=sys.stderr)
    if chosen.reaction and len(motion.t):
        motion.reaction(chosen.reaction).plot().savefig(chosen.figure, dpi=150)
        print(f"wrote {chosen.figure}", file=sys.stderr)
