"""``sarrus optimize FILE``: the optimal parameters of a model, or estimates from measurements."""

from __future__ import annotations

import argparse
from pathlib import Path

from .. import shared
from ..answer import Answer
from ..progress import Bar
from ..values import refuse_unwritable

PURPOSE = "find the optimal parameters of a model, or estimate them from measurements"
EXAMPLES = (
    "sarrus optimize softest.yaml",
    "sarrus optimize softest.yaml --figure convergence.png --csv designs.csv",
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """The file, and what to write."""
    parser.add_argument(
        "study", type=Path, help="a .yaml or .json file: model, parameters, minimize or fit, analysis"
    )
    shared.total_time_limit(parser)
    shared.figure(parser, "the convergence, or the fit over its measurements")
    shared.table(parser, "all designs that were tried")


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Search; 1 if the solver did not converge."""
    from ...io import load_any
    from ...studies.optimization import read_optimization_file

    refuse_unwritable([chosen.figure, chosen.csv])
    sought = read_optimization_file(chosen.study, lambda file: answer.noted(load_any(file)))
    most = int(sought.options.get("iterations", 100))
    with Bar(f"{sought.name}: simulations", most) as bar:
        found = sought.solved(lambda count, value: bar.reach(min(count, most)), chosen.total_time_limit)
    answer.show(found)
    answer.put(status=found.status, optimality=found.optimality)
    answer.put(study=sought.name, message=found.message, objective=found.value, objective_before=found.value0)
    answer.put(numbers=dict(zip(found.names, found.x, strict=True)), constraints=found.constraints)
    answer.put(simulations=len(found.history), failures=found.failures, seconds=found.seconds)
    if found.covariance.size:
        answer.put(
            covariance=found.covariance, intervals={name: found.interval(name) for name in found.names}
        )
        answer.put(hardly_determined=found.poor)
    if chosen.figure:
        import numpy as np

        axes = found.plot_fit() if found.measurements else found.plot()
        answer.draw(np.ravel(axes)[0].figure, chosen.figure)
    if chosen.csv:
        found.to_csv(chosen.csv)
        answer.wrote(chosen.csv)
    return 0 if found.success else 1
