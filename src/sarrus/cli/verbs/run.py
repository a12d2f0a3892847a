"""``sarrus run MODEL``: assemble and simulate a model file or robot description."""

from __future__ import annotations

import argparse
import time
from typing import TYPE_CHECKING

from .. import model_file, shared
from ..answer import Answer, named
from ..motion import wanted_outputs, write
from ..progress import Bar
from ..values import natural, refuse_unwritable

if TYPE_CHECKING:
    from ...results import Trajectory

STILL = 1e-12  # [m, 1] less is round-off
PURPOSE = "assemble and simulate a model file"
EXAMPLES = (
    "sarrus run crank.yaml --until 5",
    "sarrus run crank.yaml --until 5 --csv run.csv --plot slider.x slider.y --figure run.svg",
    "sarrus run crank.yaml --until 5 --method radau --rtol 1e-11 --atol 1e-12",
    "sarrus run crank.yaml --until 5 --start rates.pin=6.28",
    "sarrus run crank.yaml --until 5 --verify",
    "sarrus run panda.urdf --base floating --json",
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """The model file, the end time, and what to write."""
    model_file.arguments(parser)
    shared.times(parser)
    shared.start(parser)
    shared.tolerances(parser)
    shared.method(parser)
    shared.time_limit(parser)
    parser.add_argument(
        "--max-steps", type=natural, help="end after so many steps (where they would never end)"
    )
    parser.add_argument(
        "--verify", action="store_true", help="repeat the run with smaller tolerances, and compare both"
    )
    shared.motion_table(parser)
    shared.plot(parser)
    shared.figure(parser, "the plot", "run.png")


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Simulate; 1 if the assembly or the run failed (what was computed is still written)."""
    import numpy as np

    from ...analyses import Limits, simulate
    from ...analyses.position.initial_state import start_of
    from ...outputs import Level
    from ...system import System

    refuse_unwritable([chosen.csv, chosen.figure if chosen.plot else None])
    system = System(model_file.read(chosen, answer))
    # integrals over the motion need it
    dense = Level.HISTORY in [one.level for one in wanted_outputs(chosen, system)]
    start = start_of(system, shared.start_of(chosen))
    answer.put(model=system.name, assembly=start.message, message=start.message)
    answer.show(start.message)
    if not start.success:
        return 1
    began = time.perf_counter()
    with Bar(f"simulating {chosen.until:g} s", chosen.until) as bar:
        times = np.linspace(start.t, chosen.until, chosen.steps + 1)
        limits = Limits(time=chosen.time_limit, steps=chosen.max_steps)
        motion = simulate(
            system, start, until=chosen.until, t_eval=times, progress=bar.reach,
            method=shared.method_of(chosen), store="dense" if dense else "samples", limits=limits,
        )  # fmt: skip
    seconds = time.perf_counter() - began
    answer.show(f"{named(system.name, motion.message)}; {motion.nsteps} steps in {seconds:.2f} s")
    answer.put(status=motion.status, message=motion.message, nsteps=motion.nsteps, seconds=seconds)
    _report_end(motion, answer)
    write(chosen, motion, answer)
    return 0 if motion.success and (not chosen.verify or _agrees(motion, answer)) else 1


def _agrees(motion: Trajectory, answer: Answer) -> bool:
    """Whether a finer run agrees; both are printed."""
    from ...analyses import verify

    found = verify(motion)
    answer.show(found)
    names = ("name", "unit", "value", "finer", "difference", "digits")
    values = [{name: getattr(one, name) for name in names} for one in found.values]
    answer.put(verification={"agree": found.agree, "message": found.message, "values": values})
    return found.agree


def _report_end(motion: Trajectory, answer: Answer) -> None:
    """Print the positions of the bodies at the last time."""
    import numpy as np

    for body in motion.bodies if len(motion.t) else ():
        x, y, z = motion[body].position[-1]
        answer.show(f"  {body:<24} x = {x:+.9f}  y = {y:+.9f}  z = {z:+.9f} m")
    if len(motion.t) > 1 and np.ptp(np.asarray(motion.q), axis=0).max() < STILL:
        answer.show("  nothing moved: it rests, or has no freedom; see sarrus check")
    names = ("position", "euler", "velocity", "angular_velocity_global", "angular_velocity_body")
    end = {
        body: {name: getattr(motion[body], name)[-1] for name in names}
        for body in motion.bodies
        if len(motion.t)
    }
    answer.put(t=motion.t[-1] if len(motion.t) else None, bodies=end)
