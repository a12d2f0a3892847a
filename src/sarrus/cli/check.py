"""``sarrus check MODEL``: a model in words, its freedom, and every derivative against an independent one."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from . import model_file
from .progress import Bar
from .values import figure_file, natural, refuse_unwritable

if TYPE_CHECKING:
    from ..model import Model


def arguments(parser: argparse.ArgumentParser) -> None:
    """The model file, the seed of the random states, and a file for a drawing."""
    model_file.arguments(parser)
    parser.add_argument(
        "--seed", type=natural, default=0, help="of the random velocities, directions and multipliers"
    )
    parser.add_argument("--draw", type=figure_file, metavar="FILE", help="draw the model, .png, .svg or .pdf")


def run(chosen: argparse.Namespace) -> int:
    """Print the words and the table; 1 if something does not agree."""
    from ..analyses import assemble, mobility
    from ..elements import OPERATORS
    from ..model import describe
    from ..system import System

    refuse_unwritable([chosen.draw])
    model = model_file.read(chosen)
    system = System(model)
    start = assemble(system)
    found = str(mobility(system, start.q)) if start.success else start.message
    print(describe(model), found, sep="\n", end="\n\n", flush=True)
    if chosen.draw:
        _draw(model, chosen.draw)
    with Bar("compiling and checking operators", len(OPERATORS)) as bar:
        report = system.check_derivatives(seed=chosen.seed, progress=bar.step)
    print(report)
    return 0 if report.ok else 1


def _draw(model: Model, file: Path) -> None:
    from ..views import mechanism_figure

    mechanism_figure(model).savefig(file, dpi=150, bbox_inches="tight")
    print(f"wrote {file}", file=sys.stderr)
