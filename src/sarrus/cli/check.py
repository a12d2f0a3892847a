"""``sarrus check MODEL``: degrees of freedom and redundancies; every derivative against an independent one."""

from __future__ import annotations

import argparse

from .progress import Bar


def arguments(parser: argparse.ArgumentParser) -> None:
    """The model file, and the seed of the random states."""
    parser.add_argument("model", help="a .yaml or .json model file")
    parser.add_argument(
        "--seed", type=int, default=0, help="of the random velocities, directions and multipliers"
    )


def run(chosen: argparse.Namespace) -> int:
    """Print the table; 1 if something does not agree."""
    from ..analyses import assemble, mobility
    from ..elements import OPERATORS
    from ..model import load
    from ..system import System

    system = System(load(chosen.model))
    start = assemble(system)
    print(mobility(system, start.q) if start.success else start.message)
    with Bar("compiling and checking operators", len(OPERATORS)) as bar:
        report = system.check_derivatives(seed=chosen.seed, progress=bar.step)
    print(report)
    return 0 if report.ok else 1
