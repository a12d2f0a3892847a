"""``sarrus workspace MODEL``: what outputs of a mechanism can reach, as picture, table and report."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from . import model_file, shared
from .answer import Answer
from .progress import Bar
from .values import natural, refuse_unwritable

if TYPE_CHECKING:
    from ..analyses.workspace.formulate import Limits
    from ..results import Workspace

EXAMPLES = (
    "sarrus workspace arm.yaml --output tool.x tool.y --limit q1=-60deg,60deg q2=-60deg,60deg",
    "sarrus workspace robot.urdf --output 'hand(0, 0, 0.1).x' hand.z --fix q1=0 q3=0 --csv map.csv",
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """The model, what moves, what limits it, and what to write."""
    model_file.arguments(parser)
    parser.add_argument(
        "--output",
        nargs=2,
        required=True,
        metavar="NAME",
        help="two functions, e.g. tool.x tool.y, 'tool(0.1, 0, 0).x', pin.angle, platform.turn_z",
    )
    parser.add_argument(
        "--limit",
        nargs="+",
        default=[],
        type=_limit,
        metavar="NAME=LOW,HIGH",
        help="limits, e.g. pin=-60deg,60deg or slide=,0.4; by default those of a robot description",
    )
    parser.add_argument(
        "--fix", nargs="+", default=[], type=_fixed, metavar="NAME=VALUE", help="functions that keep a value"
    )
    parser.add_argument("--samples", type=natural, default=1000, help="random positions that test it (1000)")
    shared.seed(parser, "numbers")
    shared.figure(parser, "the picture", "workspace.png")
    shared.table(parser, "all curves")
    parser.add_argument("--report", type=Path, help="file for the report, which is also printed")


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Map and draw; 1 if the map is not complete."""
    from ..analyses import WorkspaceMap, verify_workspace
    from ..system import System

    refuse_unwritable([chosen.figure, chosen.csv, chosen.report])
    system = System(model_file.read(chosen))
    limits: Limits = dict(chosen.limit) if chosen.limit else "model"
    map_ = WorkspaceMap(system, chosen.output, limits=limits, fixed=dict(chosen.fix), seed=chosen.seed)
    with Bar("tracing curves", map_.repeats) as bar:
        for _ in map_:
            bar.reach(min(map_.in_a_row, map_.repeats))
    with Bar("testing the map", 1):
        found = verify_workspace(map_.result(), chosen.samples)
    answer.say(found)
    answer.put(model=system.name, status=found.status, message=found.message)
    answer.put(area=found.area, area_error=found.area_error, perimeter=found.perimeter)
    answer.put(parts=[part.area for part in found.components])
    _write(chosen, found, answer)
    return 0 if found.success else 1


def _write(chosen: argparse.Namespace, found: Workspace, answer: Answer) -> None:
    answer.draw(found.plot().figure, chosen.figure)
    if chosen.csv:
        found.to_csv(chosen.csv)
        answer.wrote(chosen.csv)
    if chosen.report:
        chosen.report.write_text(f"{found}\n", encoding="utf-8")
        answer.wrote(chosen.report)


def _limit(text: str) -> tuple[str, tuple[float | None, float | None]]:
    name, _, ends = text.partition("=")
    low, comma, high = ends.partition(",")
    if not comma:
        raise argparse.ArgumentTypeError(f"must be NAME=LOW,HIGH, but is {text}")
    return name, (_number(low), _number(high))


def _fixed(text: str) -> tuple[str, float]:
    name, _, value = text.partition("=")
    found = _number(value)
    if found is None:
        raise argparse.ArgumentTypeError(f"must be NAME=VALUE, but is {text}")
    return name, found


def _number(text: str) -> float | None:
    """A number, with a unit if wanted; nothing for no text."""
    from ..model import ModelError, parse_expression

    if not text.strip():
        return None
    try:
        return float(parse_expression(text).value())
    except ModelError as trouble:
        raise argparse.ArgumentTypeError(f"{text!r}: {trouble.sentence}") from None
