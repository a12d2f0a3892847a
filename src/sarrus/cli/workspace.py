"""``sarrus workspace MODEL``: what outputs of a mechanism can reach, as picture, table and report."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import model_file, shared
from .answer import Answer
from .progress import Bar
from .values import natural, positive, refuse_unwritable

if TYPE_CHECKING:
    from ..analyses.workspace.formulate import Limits
    from ..results import Workspace, WorkspaceRange, WorkspaceVolume
    from ..system import System

EXAMPLES = (
    "sarrus workspace arm.yaml --output tool.x tool.y --limit q1=-60deg,60deg q2=-60deg,60deg",
    "sarrus workspace delta.yaml --output tool.x tool.y tool.z --rtol 1e-6 --view reach.html --netcdf reach.nc",
    "sarrus workspace robot.urdf --output 'hand(0, 0, 0.1).x' hand.z --fix q1=0 q3=0 --csv map.csv",
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """The model, what moves, what limits it, and what to write."""
    model_file.arguments(parser)
    parser.add_argument(
        "--output",
        nargs="+",
        required=True,
        metavar="NAME",
        help="one to three functions, e.g. tool.x tool.y, 'tool(0.1, 0, 0).x', pin.angle, platform.turn_z",
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
    parser.add_argument(
        "--netcdf", type=Path, metavar="FILE", help="file for curves or the surface as arrays, .nc"
    )
    parser.add_argument(
        "--view", type=Path, metavar="FILE", help="file for the surface of three outputs, .html or .glb"
    )
    parser.add_argument("--rtol", type=positive, default=1e-4, help="error of a volume, relative (1e-4)")
    parser.add_argument("--report", type=Path, help="file for the report, which is also printed")


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Map and draw; 1 if the map is not complete."""
    from ..system import System

    refuse_unwritable([chosen.figure, chosen.csv, chosen.report, chosen.netcdf, chosen.view])
    system = System(model_file.read(chosen))
    limits: Limits = dict(chosen.limit) if chosen.limit else "model"
    given = {"limits": limits, "fixed": dict(chosen.fix), "seed": chosen.seed}
    by_count: dict[int, Any] = {1: _interval, 2: _area, 3: _volume}
    found = by_count.get(len(chosen.output), _area)(system, chosen, answer, given)
    answer.say(found)
    answer.put(model=system.name, status=found.status, message=found.message)
    if len(chosen.output) > 1:
        answer.draw(found.plot().figure, chosen.figure)
    _write(chosen, found, answer)
    return 0 if found.success else 1


def _interval(system: System, chosen: argparse.Namespace, answer: Answer, given: Any) -> WorkspaceRange:
    from ..analyses import workspace_range

    found = workspace_range(system, chosen.output[0], **given)
    answer.put(intervals=found.intervals)
    return found


def _area(system: System, chosen: argparse.Namespace, answer: Answer, given: Any) -> Workspace:
    from ..analyses import WorkspaceMap, verify_workspace

    map_ = WorkspaceMap(system, chosen.output, **given)
    with Bar("tracing curves", map_.repeats) as bar:
        for _ in map_:
            bar.reach(min(map_.in_a_row, map_.repeats))
    with Bar("testing the map", 1):
        found = verify_workspace(map_.result(), chosen.samples)
    answer.put(area=found.area, area_error=found.area_error, perimeter=found.perimeter)
    answer.put(parts=[part.area for part in found.components])
    return found


def _volume(system: System, chosen: argparse.Namespace, answer: Answer, given: Any) -> WorkspaceVolume:
    from ..analyses import workspace_volume

    with Bar("tracing slices", 1):
        found = workspace_volume(system, chosen.output, rtol=chosen.rtol, samples=chosen.samples, **given)
    answer.put(volume=found.volume, volume_error=found.volume_error, critical=found.critical)
    return found


def _write(chosen: argparse.Namespace, found: Any, answer: Answer) -> None:
    """The files that were asked for; a result that does not come as such a file says so."""
    for file, method in ((chosen.csv, "to_csv"), (chosen.netcdf, "to_netcdf"), (chosen.view, "view")):
        if file is not None:
            if not hasattr(found, method):
                from ..model.errors import SarrusError

                raise SarrusError(f"{file}: {len(chosen.output)} outputs are not written so; leave it out")
            getattr(found, method)(file)
            answer.wrote(file)
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
