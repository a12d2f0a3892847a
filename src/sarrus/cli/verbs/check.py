"""``sarrus check MODEL``: a model in words, its freedom, and every derivative against an independent one."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from .. import model_file, shared
from ..answer import Answer
from ..progress import Bar
from ..values import figure_file, refuse_unwritable

if TYPE_CHECKING:
    from ...system.check import Report

PURPOSE = "describe a model in words, and compare every derivative with an independent one"
EXAMPLES = ("sarrus check crank.yaml", "sarrus check crank.yaml --draw crank.png --seed 3")


def arguments(parser: argparse.ArgumentParser) -> None:
    """The model file, the seed of the random states, and a file for a drawing."""
    model_file.arguments(parser)
    shared.seed(parser, "velocities, directions and multipliers")
    parser.add_argument("--operators", action="store_true", help="list every operator with its error")
    parser.add_argument("--draw", type=figure_file, metavar="FILE", help="draw the model, .png, .svg or .pdf")


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Print the words and the verdict, with the table if something does not agree; that is exit code 1."""
    from ...analyses import assemble, mobility
    from ...elements import OPERATORS
    from ...model import describe
    from ...outputs import find_output
    from ...system import System

    refuse_unwritable([chosen.draw])
    model = model_file.read(chosen, answer)
    system = System(model)
    for name in model.outputs:
        find_output(system, name)
    start = assemble(system)
    found = mobility(system, start.q).summary() if start.success else start.message
    description = describe(model)
    answer.show(f"{description}\n{found}\n")
    answer.put(model=system.name, description=description, mobility=found, counts=system.counts())
    if chosen.draw:
        from ...views import mechanism_figure

        answer.draw(mechanism_figure(model), chosen.draw)
    with Bar("compiling and checking operators", len(OPERATORS)) as bar:
        report = system.check_derivatives(seed=chosen.seed, progress=bar.step)
    table = str(report)
    verdict = table.splitlines()[-1]
    answer.show(table if chosen.operators or not report.ok else verdict)
    answer.put(message=verdict, derivatives_agree=report.ok, derivatives=_table(report))
    return 0 if report.ok else 1


def _table(report: Report) -> list[dict[str, Any]]:
    """The findings, one mapping for each operator."""
    return [
        {"operator": one.operator.name, "entries": one.entries, "error": one.error, "ok": one.ok}
        for one in report.findings
    ]
