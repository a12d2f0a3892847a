"""``sarrus view MODEL``: the mechanism in three dimensions, in the browser or as a file."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from .. import model_file
from ..answer import Answer, named
from ..progress import Bar
from ..values import duration, refuse_unwritable, scene_file

if TYPE_CHECKING:
    from ...model import Model
    from ...system import System

PURPOSE = "show a model file, or its motion, in the browser"
EXAMPLES = (
    "sarrus view four_bar.yaml",
    "sarrus view four_bar.yaml --assemble --output four_bar.png",
    "sarrus view four_bar.yaml --until 2 --trace coupler --output motion.html",
)
FILMS = (".gif", ".mp4")


def arguments(parser: argparse.ArgumentParser) -> None:
    """The model file, whether it moves, and where to write."""
    model_file.arguments(parser)
    parser.add_argument(
        "--assemble", action="store_true", help="bring the parts together first, as `run` does"
    )
    parser.add_argument(
        "--until",
        type=duration,
        metavar="T",
        help="simulate to this time [s], or with a unit: 500 ms, and play the motion",
    )
    parser.add_argument(
        "--trace",
        nargs="+",
        default=[],
        metavar="POINT",
        help="draw the paths of these bodies and points, e.g. rod 'rod(0.1, 0, 0)'",
    )
    parser.add_argument(
        "--plot",
        nargs="+",
        default=[],
        metavar="NAME",
        help="outputs whose curves the page of a motion shows",
    )
    parser.add_argument("--follow", metavar="BODY", help="move the camera with this body")
    parser.add_argument("--names", action="store_true", help="begin with the names of bodies shown")
    parser.add_argument(
        "--output",
        type=scene_file,
        metavar="FILE",
        help="write .html or .glb, of a motion also .gif or .mp4, instead of opening the browser",
    )


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Draw the model or its motion; 1 if the assembly or the simulation failed."""
    from ...model.errors import SarrusError

    refuse_unwritable([chosen.output])
    if chosen.output and chosen.output.suffix.lower() in FILMS and not chosen.until:
        raise SarrusError(f"{chosen.output}: a film needs a motion. Give its duration with --until.")
    for option in ("plot", "trace", "follow"):
        if getattr(chosen, option) and not chosen.until:
            raise SarrusError(f"--{option} needs a motion. Give its duration with --until.")
    model = model_file.read(chosen, answer)
    return _motion(model, chosen, answer) if chosen.until else _still(model, chosen, answer)


def _still(model: Model, chosen: argparse.Namespace, answer: Answer) -> int:
    from ...analyses import assemble
    from ...system import System
    from ...views import view

    start = assemble(System(model)) if chosen.assemble else None
    answer.put(model=model.name, message="drawn in the position of the file")
    if start is not None:
        answer.show(start.message)
        answer.put(message=start.message)
    view(model, chosen.output, q=None if start is None else start.q, names=chosen.names)
    _report(chosen, answer)
    return 0 if start is None or start.success else 1


def _motion(model: Model, chosen: argparse.Namespace, answer: Answer) -> int:
    from ...analyses import assemble, simulate
    from ...system import System
    from ...views import animate

    system = System(model)
    _refuse_unknown(chosen, system)
    start = assemble(system)
    answer.show(start.message)
    answer.put(model=system.name, message=start.message)
    if not start.success:
        return 1
    with Bar(f"simulating {chosen.until:g} s", chosen.until) as bar:
        motion = simulate(system, start, until=chosen.until, progress=bar.reach)
    answer.show(named(system.name, motion.message))
    answer.put(message=motion.message)
    options = {"traces": chosen.trace, "outputs": chosen.plot, "names": chosen.names, "follow": chosen.follow}
    animate(motion, chosen.output, **options)
    _report(chosen, answer)
    return 0 if motion.success else 1


def _refuse_unknown(chosen: argparse.Namespace, system: System) -> None:
    """Raise a SarrusError for a body or output that is not there, before anything is simulated."""
    from ...model.errors import SarrusError
    from ...outputs import find_output
    from ...outputs.bodies import point_of

    for name in chosen.plot:
        find_output(system, name)
    for name in (*chosen.trace, *([chosen.follow] if chosen.follow else [])):
        try:
            system.coordinates_of((point_of(system, name) or (name,))[0])
        except KeyError as unknown:
            raise SarrusError(unknown.args[0]) from None


def _report(chosen: argparse.Namespace, answer: Answer) -> None:
    """Report the written file; without one, a page was opened in the browser."""
    if chosen.output:
        answer.wrote(chosen.output)
