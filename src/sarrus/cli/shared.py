"""Arguments that several verbs take: each spelt, checked and explained once."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..defaults import ATOL, RTOL, RTOL_OF_ORDER_2
from .values import duration, figure_file, finite, intervals, natural, positive, start_entry


def times(parser: argparse.ArgumentParser) -> None:
    """``--until`` and ``--steps``: the times at which a motion is wanted."""
    until(parser)
    parser.add_argument("--steps", type=intervals, default=1000, help="output intervals (1000)")


def time_limit(parser: argparse.ArgumentParser) -> None:
    """``--time-limit``: how long the analysis may take."""
    parser.add_argument(
        "--time-limit", type=positive, metavar="S", help="end after so many seconds, with what was computed"
    )


def start(parser: argparse.ArgumentParser) -> None:
    """``--start``: what a motion starts from, by the names of model and study files."""
    parser.add_argument(
        "--start",
        nargs="+",
        type=start_entry,
        metavar="NAME=VALUE",
        help="what the motion starts from: rates of joints, rates.pin=5 or rates.pin='30 deg/s', the equilibrium of "
        "the model, equilibrium=true, or a saved run, run=drop.sarrus (its end, or its state at a time, t=2) (the "
        "model's own initial state)",
    )


def start_of(chosen: argparse.Namespace) -> dict[str, Any] | None:
    """The start chosen, as study files write it."""
    if not chosen.start:
        return None
    given = dict(chosen.start)
    rates = {name.removeprefix("rates."): x for name, x in given.items() if name.startswith("rates.")}
    others = {name: x for name, x in given.items() if not name.startswith("rates.")}
    return {**others, **({"rates": rates} if rates else {})}


def total_time_limit(parser: argparse.ArgumentParser) -> None:
    """``--total-time-limit``: how long all simulations together may take; `time_limit` in a file is that of each."""
    parser.add_argument(
        "--total-time-limit",
        "--time-limit",
        dest="total_time_limit",
        type=positive,
        metavar="S",
        help="end after so many seconds, with what was computed (time_limit in the file is that of each simulation)",
    )


def until(parser: argparse.ArgumentParser) -> None:
    """``--until``: the end of a motion."""
    parser.add_argument(
        "--until", type=duration, default=1.0, help="end time [s], or with a unit: 500 ms (1)"
    )


def tolerances(parser: argparse.ArgumentParser) -> None:
    """``--rtol`` and ``--atol`` of a simulation."""
    parser.add_argument(
        "--rtol",
        type=positive,
        help=f"relative tolerance ({RTOL:g}, of hht and generalizedalpha {RTOL_OF_ORDER_2:g})",
    )
    parser.add_argument(
        "--atol",
        type=positive,
        default=ATOL,
        help="absolute tolerance (none: rtol is of the size of the motion)",
    )


def method(parser: argparse.ArgumentParser, *, stores_steps: bool = False) -> None:
    """``--method``: how a motion is integrated; with stored steps where there are derivatives."""
    from ..analyses.integration_methods import METHODS, STORING_STEPS

    known = [*(STORING_STEPS if stores_steps else METHODS)]
    parser.add_argument("--method", choices=known, default=known[0], help=f"how to integrate ({known[0]})")


def method_of(chosen: argparse.Namespace) -> Any:
    """The method chosen, with the tolerances chosen and its own options as they are by default."""
    from ..analyses.dynamics.integrators.differentiable import method_with_options
    from ..analyses.dynamics.stepping.step_control import with_control

    return with_control(method_with_options(chosen.method), rtol=chosen.rtol, atol=chosen.atol)


def rest(parser: argparse.ArgumentParser) -> None:
    """``--time`` and ``--nearest``: which equilibrium is wanted."""
    parser.add_argument("--time", type=finite, default=0.0, help="time at which drivers are held [s] (0)")
    parser.add_argument("--nearest", action="store_true", help="the nearest equilibrium, be it stable or not")


def seed(parser: argparse.ArgumentParser, contents: str, default: int = 0) -> None:
    """``--seed``: of what is random."""
    parser.add_argument("--seed", type=natural, default=default, help=f"of the random {contents} ({default})")


def table(parser: argparse.ArgumentParser, contents: str) -> None:
    """``--csv``: a file for what can be put in a table."""
    parser.add_argument("--csv", type=Path, metavar="FILE", help=f"file for {contents} as a table")


def motion_table(parser: argparse.ArgumentParser) -> None:
    """``--csv`` of a motion, and ``--columns``: which outputs it has."""
    table(parser, "t, q and v, or t and the columns chosen,")
    parser.add_argument(
        "--columns",
        nargs="+",
        default=[],
        metavar="NAME",
        help="outputs, e.g. slider.x pin.force.z spring.tension",
    )


def plot(parser: argparse._ActionsContainer) -> None:
    """``--plot``: outputs that are drawn."""
    parser.add_argument(
        "--plot", nargs="+", metavar="NAME", help="outputs to draw, e.g. slider.x pin.force.z spring.tension"
    )


def figure(parser: argparse.ArgumentParser, contents: str, default: str | None = None) -> None:
    """``--figure``: a file for a picture."""
    ending = f" ({default})" if default else ""
    parser.add_argument(
        "--figure",
        type=figure_file,
        default=default,
        metavar="FILE",
        help=f"file for {contents}, .png, .svg or .pdf{ending}",
    )
