"""``sarrus run MODEL``: assemble and simulate a model file or robot description."""

from __future__ import annotations

import argparse
import sys
import time

from . import model_file
from .progress import Bar


def arguments(parser: argparse.ArgumentParser) -> None:
    """The model file, the end time, and what to write."""
    model_file.arguments(parser)
    parser.add_argument("--until", type=float, default=1.0, help="end time [s] (1)")
    parser.add_argument("--steps", type=int, default=1000, help="output intervals (1000)")
    parser.add_argument("--rtol", type=float, default=1e-8, help="relative tolerance (1e-8)")
    parser.add_argument("--atol", type=float, default=1e-10, help="absolute tolerance (1e-10)")
    parser.add_argument("--csv", help="file for t, q and v as a table")
    parser.add_argument("--plot", nargs="+", metavar="NAME", help="coordinates to draw, e.g. slider.x")
    parser.add_argument("--figure", default="run.png", help="file for the plot, .png or .svg (run.png)")


def run(chosen: argparse.Namespace) -> int:
    """Simulate; 1 if the assembly or the run failed (what was computed is still written)."""
    import numpy as np

    from ..analyses import assemble, simulate
    from ..model.errors import SarrusError
    from ..system import System

    if not chosen.until > 0 or chosen.steps < 1:
        raise SarrusError("--until must be a positive time and --steps at least 1")
    system = System(model_file.read(chosen))
    start = assemble(system)
    print(start.message)
    if not start.success:
        return 1
    began = time.perf_counter()
    with Bar(f"simulating {chosen.until:g} s", chosen.until) as bar:
        times = np.linspace(0.0, chosen.until, chosen.steps + 1)
        tolerances = {"rtol": chosen.rtol, "atol": chosen.atol}
        motion = simulate(system, start, until=chosen.until, t_eval=times, progress=bar.reach, **tolerances)
    print(f"{system.name}: {motion.message}; {motion.nsteps} steps in {time.perf_counter() - began:.2f} s")
    for body in motion.bodies:
        x, y, z = motion[body].position[-1]
        print(f"  {body:<24} x = {x:+.9f}  y = {y:+.9f}  z = {z:+.9f} m")
    _write(chosen, motion)
    return 0 if motion.success else 1


def _write(chosen: argparse.Namespace, motion: object) -> None:
    from ..model.errors import SarrusError
    from ..results import Trajectory
    from ..views import plot

    assert isinstance(motion, Trajectory)
    if chosen.csv:
        motion.to_csv(chosen.csv)
        print(f"wrote {chosen.csv}", file=sys.stderr)
    if chosen.plot:
        try:
            plot(motion, *chosen.plot).figure.savefig(chosen.figure, dpi=150)
        except KeyError as unknown:
            raise SarrusError(unknown.args[0]) from None
        print(f"wrote {chosen.figure}", file=sys.stderr)
