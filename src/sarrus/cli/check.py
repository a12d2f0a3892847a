"""``sarrus check MODEL``: every derivative of a model against an independent one."""

from __future__ import annotations

import argparse

from . import model_file
from .progress import Bar


def arguments(parser: argparse.ArgumentParser) -> None:
    """The model file, and the seed of the random states."""
    model_file.arguments(parser)
    parser.add_argument(
        "--seed", type=int, default=0, help="of the random velocities, directions and multipliers"
    )


def run(chosen: argparse.Namespace) -> int:
    """Print the table; 1 if something does not agree."""
    from ..elements import OPERATORS
    from ..system import System

    system = System(model_file.read(chosen))
    with Bar("compiling and checking operators", len(OPERATORS)) as bar:
        report = system.check_derivatives(seed=chosen.seed, progress=bar.step)
    print(report)
    return 0 if report.ok else 1
