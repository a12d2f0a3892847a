"""``sarrus paper``: the paper's numerical experiments on its two mechanisms, Tables 1 to 6."""

from __future__ import annotations

import argparse
import json

from .progress import Bar
from .values import natural

MECHANISMS = ("slider_crank", "hmmwv")


def arguments(parser: argparse.ArgumentParser) -> None:
    """JSON, and the seed of the random state."""
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument(
        "--seed", type=natural, default=1, help="of the random velocity, multipliers and accelerations"
    )


def run(chosen: argparse.Namespace) -> int:
    """Print the tables."""
    from ..analyses.paper import STEPS, experiment
    from ..mechanisms import path
    from ..model import load
    from ..system import System
    from ..views.tables import paper_tables

    found = {}
    with Bar("compiling and timing", len(MECHANISMS)) as bar:
        for name in MECHANISMS:
            bar.step(name)
            found[name] = experiment(System(load(path(name))), seed=chosen.seed)
    if chosen.json:
        print(json.dumps({name: one.as_json() for name, one in found.items()}))
    else:
        print(paper_tables(list(found.values()), STEPS))
    return 0
