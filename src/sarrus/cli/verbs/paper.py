"""``sarrus paper``: the paper's numerical experiments on its two mechanisms, Tables 1 to 6."""

from __future__ import annotations

import argparse

from .. import shared
from ..answer import Answer
from ..progress import Bar

MECHANISMS = ("slider_crank", "hmmwv")
PURPOSE = "print the numerical experiments of the paper, Tables 1 to 6"
EXAMPLES = ("sarrus paper", "sarrus paper --json --seed 7")


def arguments(parser: argparse.ArgumentParser) -> None:
    """The seed of the random state."""
    shared.seed(parser, "velocity, multipliers and accelerations", 1)


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Print the tables."""
    from ...analyses.paper import STEPS, experiment
    from ...mechanisms import path
    from ...model import load
    from ...system import System
    from ...views.figures.paper_tables import paper_tables

    found = {}
    with Bar("compiling and timing", len(MECHANISMS)) as bar:
        for name in MECHANISMS:
            bar.step(name)
            found[name] = experiment(System(load(path(name))), seed=chosen.seed)
    answer.put(**{name: one.as_json() for name, one in found.items()})
    answer.show(paper_tables(list(found.values()), STEPS))
    return 0
