"""``sarrus sensitivity MODEL``: derivatives of responses of a motion, with the parameters ranked by influence."""

from __future__ import annotations

import argparse

from .. import model_file, shared
from ..answer import Answer
from ..values import natural, refuse_unwritable

PURPOSE = "rank the parameters of a model by their influence on responses of its motion"
EXAMPLES = (
    "sarrus sensitivity crank.yaml --until 2 --response slider.x",
    "sarrus sensitivity crank.yaml --until 2 --response 'max(slider.x) - min(slider.x)' 'rms(spring.tension)' "
    "--wrt spring rod.mass pin.point --figure tornado.png",
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """The model, the motion, what is asked, and what to write."""
    model_file.arguments(parser)
    shared.until(parser)
    shared.start(parser)
    parser.add_argument(
        "--response",
        nargs="+",
        required=True,
        metavar="FORMULA",
        help="e.g. slider.x (its final value), 'integral(slider.velocity.x**2)', 'max(spring.tension)'",
    )
    parser.add_argument(
        "--wrt",
        nargs="+",
        metavar="NAME",
        help="numbers or parts of the model, e.g. spring.k rod pin.point, or parameters of its file (all numbers)",
    )
    shared.tolerances(parser)
    shared.method(parser, stores_steps=True)
    parser.add_argument("--most", type=natural, default=20, help="how many numbers are listed (20)")
    shared.figure(parser, "a tornado plot")


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Simulate, differentiate, and list what matters most."""
    import numpy as np

    from ...analyses import Problem
    from ...analyses.optimization import DesignError
    from ...analyses.sensitivity.combined import response_of
    from ...analyses.sensitivity.parameters.design_start import DesignStart
    from ...system import System
    from ...views import plot_gradient
    from ...views.figures.style import figure_of

    refuse_unwritable([chosen.figure])
    system = System(model_file.read(chosen, answer))
    start = DesignStart.of(system, shared.start_of(chosen))
    wanted = [response_of(one, one) for one in chosen.response]
    method = shared.method_of(chosen)
    problem = Problem(system, wanted, chosen.wrt, until=chosen.until, start=start, method=method)
    try:
        with np.errstate(invalid="ignore", divide="ignore"):  # reported below
            found = problem.gradient(problem.x0)
    except DesignError as error:
        answer.show(error)
        answer.put(model=system.name, message=str(error))
        return 1
    for row in range(len(found.responses)):
        answer.show(found.table(row, chosen.most))
    answer.put(model=system.name, message=f"responses: {len(found.responses)}, numbers: {len(found.names)}")
    answer.put(names=found.names, at=found.at, units=found.units)
    answer.put(
        responses={
            name: {
                "value": found.values[row],
                "unit": found.response_units[row],
                "gradient": found.matrix[row],
                "units": [found.unit(one, row) for one in found.names],
                "ranked": found.ranked(row),
            }
            for row, name in enumerate(found.responses)
        }
    )
    if chosen.figure:
        figure = figure_of(7.0, 3.2)
        plot_gradient(found, figure, most=min(chosen.most, 15))
        answer.draw(figure, chosen.figure)
    return 0
