"""``sarrus workspace MODEL``: what outputs of a mechanism can reach, as picture, table and report."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import model_file, shared
from ..answer import Answer
from ..progress import Bar
from ..values import figure_file, natural, positive, refuse_unwritable

if TYPE_CHECKING:
    from ...analyses.workspace.problem.formulation import Limits
    from ...results import InputSingularities, Workspace, WorkspaceField, WorkspaceRange, WorkspaceVolume
    from ...results.maps.input_singularities import Lost
    from ...system import System

QUANTITIES = (  # see results/maps/workspace_field.py
    "solutions",
    "manipulability",
    "worst_manipulability",
    "conditioning",
    "worst_conditioning",
    "turn",
)
KINDS = ("outer", "void", "barrier", "crossable")
MOMENT = 1e-6  # s
ENDED = ("time limit", "stopped")
LOST: tuple[Lost, ...] = ("inputs", "outputs")
PURPOSE = "map what two outputs of a model can reach, its boundary and barriers"
EXAMPLES = (
    "sarrus workspace arm.yaml --output tool.x tool.y --limit q1=-60deg,60deg q2=-60deg,60deg",
    "sarrus workspace delta.yaml --output tool.x tool.y tool.z --rtol 1e-6 --view reach.html --netcdf reach.nc",
    "sarrus workspace five_bar.yaml --output tip.x tip.y --inputs a b --field conditioning --singular lost.png",
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
        help="one to three functions, e.g. tool.x tool.y, 'tool(0.1, 0, 0).x', pin.angle, platform.rotation_z",
    )
    parser.add_argument(
        "--limit",
        nargs="+",
        default=[],
        type=_limit,
        metavar="NAME=LOW,HIGH",
        help="limits, e.g. pin=-60deg,60deg or slide=,0.4; by default those of a robot description.",
    )
    parser.add_argument(
        "--fix", nargs="+", default=[], type=_fixed, metavar="NAME=VALUE", help="functions that keep a value"
    )
    parser.add_argument(
        "--inputs", nargs="+", default=[], metavar="NAME", help="what drives it, for --field and --singular"
    )
    parser.add_argument("--field", choices=QUANTITIES, help="what the picture shows in colours")
    parser.add_argument("--turn", metavar="NAME", help="what can turn at a place, for --field turn")
    parser.add_argument(
        "--at",
        action="append",
        type=_place,
        metavar="X,Y",
        help="a place at which the mechanism is drawn; --at=-1,2",
    )
    parser.add_argument("--curves", nargs="+", choices=KINDS, help="curves that are drawn (all)")
    parser.add_argument("--samples", type=natural, default=1000, help="random positions that test it (1000)")
    shared.seed(parser, "numbers")
    shared.time_limit(parser)
    shared.figure(parser, "the picture", "workspace.png")
    shared.table(parser, "all curves, or the field")
    parser.add_argument(
        "--netcdf", type=Path, metavar="FILE", help="file for curves, field or surface as arrays, .nc"
    )
    parser.add_argument(
        "--view", type=Path, metavar="FILE", help="file for the surface of three outputs, .html or .glb"
    )
    parser.add_argument(
        "--singular",
        type=figure_file,
        metavar="FILE",
        help="picture, over two inputs, of where they lose control and outputs a direction",
    )
    parser.add_argument("--rtol", type=positive, default=1e-4, help="error of a volume, relative (1e-4)")
    parser.add_argument("--report", type=Path, help="file for the report, which is also printed")


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Map and draw; 1 if the map, or what is drawn over it, is not complete."""
    from ...model.announcement import announce
    from ...results.saving.exported_file import exporting
    from ...system import System

    refuse_unwritable([chosen.figure, chosen.csv, chosen.report, chosen.netcdf, chosen.view, chosen.singular])
    _refuse_options(chosen)
    system = System(model_file.read(chosen, answer))
    limits: Limits = dict(chosen.limit) if chosen.limit else "model"
    given = {
        "limits": limits,
        "fixed": dict(chosen.fix),
        "seed": chosen.seed,
        "clock": Clock(chosen.time_limit),
    }
    by_count: dict[int, Any] = {1: _interval, 2: _area, 3: _volume}
    found = by_count.get(len(chosen.output), _area)(system, chosen, answer, **given)
    answer.show(found)
    answer.put(model=system.name, status=found.status, message=found.message)
    texts, shown = [str(found)], found
    if found.status in ENDED and (chosen.field or chosen.singular):
        announce(
            [f"{system.name}: --field and --singular are left out, since the map ended before its time."]
        )
        chosen.field = chosen.singular = None
    if chosen.field:
        shown = _field(found, chosen, answer, given["clock"])
        texts.append(str(shown))
    lost = _singular(system, chosen, answer, **given) if chosen.singular else []
    texts += [str(one) for one in lost]
    if len(chosen.output) > 1:
        answer.draw(_picture(shown, chosen, lost).figure, chosen.figure)
    _write(chosen, shown, answer)
    if chosen.report:
        with exporting(chosen.report) as draft:
            draft.write_text("\n\n".join(texts) + "\n", encoding="utf-8")
        answer.wrote(chosen.report)
    return 0 if all(one.success for one in (found, shown, *lost)) else 1


def _refuse_options(chosen: argparse.Namespace) -> None:
    """Options that only two outputs have, or that need others."""
    from ...model.errors import SarrusError

    planar = {
        "--field": chosen.field,
        "--at": chosen.at,
        "--curves": chosen.curves,
        "--inputs": chosen.inputs,
        "--singular": chosen.singular,
    }
    given = [option for option, value in planar.items() if value]
    if given and len(chosen.output) != 2:
        raise SarrusError(f"{given[0]} is for two outputs, not {len(chosen.output)}. Leave it out.")
    _refuse_ignored(chosen)
    if chosen.singular and not chosen.inputs:
        raise SarrusError("--singular needs to know what drives the mechanism. Add --inputs NAME ...")
    if chosen.turn and chosen.field != "turn":
        raise SarrusError("--turn is for --field turn. Add it.")
    if chosen.field == "turn" and not chosen.turn:
        raise SarrusError(
            "--field turn needs the name of a rotation. Add --turn NAME, e.g. --turn platform.rotation_z."
        )
    if chosen.field not in (None, "turn", "solutions") and not chosen.inputs:
        raise SarrusError(f"--field {chosen.field} needs to know what drives it. Add --inputs NAME ...")


def _refuse_ignored(chosen: argparse.Namespace) -> None:
    """Options that would change nothing."""
    from ...model.errors import SarrusError

    if chosen.field and (chosen.at or chosen.curves):
        option = "--at" if chosen.at else "--curves"
        raise SarrusError(f"{option} is for a picture without --field. Leave one of them out.")
    if chosen.inputs and not chosen.field and not chosen.singular:
        raise SarrusError("--inputs is for --field and --singular. Add one of them.")
    if chosen.view and len(chosen.output) == 2:
        raise SarrusError("--view is for three outputs, not 2. Leave it out.")
    written = {"--csv": chosen.csv, "--netcdf": chosen.netcdf, "--view": chosen.view}
    given = [option for option, value in written.items() if value]
    if given and len(chosen.output) == 1:
        raise SarrusError(f"{given[0]} is for more than one output. Leave it out.")


class Clock:
    """The time that is left of the time limit, which all analyses of one call share, from the first one on."""

    def __init__(self, limit: float | None) -> None:
        self._limit, self._end = limit, 0.0

    def left(self) -> float | None:
        """Seconds, none without a limit; a moment where the time is over: the analysis ends as it begins."""
        if self._limit is None:
            return None
        now = time.monotonic()
        self._end = self._end or now + self._limit
        return max(self._end - now, MOMENT)


def _field(found: Workspace, chosen: argparse.Namespace, answer: Answer, clock: Clock) -> WorkspaceField:
    from ...analyses.workspace import workspace_field

    with Bar("filling the grid", 1):
        field = workspace_field(
            found, chosen.inputs, turn=chosen.turn, seed=chosen.seed, time_limit=clock.left()
        )
    answer.show(f"\n{field.summary()}")
    answer.put(positions=field.positions, missed=field.missed)
    return field


def _singular(
    system: System, chosen: argparse.Namespace, answer: Answer, clock: Clock, **given: Any
) -> list[InputSingularities]:
    """Both kinds of singular configurations, drawn over the inputs."""
    from ...analyses import input_singularities

    found, ax = [], None
    for lost in LOST:
        with Bar(f"singular configurations of {lost}", 1):
            given["time_limit"] = clock.left()
            found.append(input_singularities(system, chosen.output, chosen.inputs, lost=lost, **given))
        ax = found[-1].plot(ax, over="inputs")
        answer.show(f"\n{found[-1].summary()}")
    answer.draw(ax.figure if ax else None, chosen.singular)
    return found


def _picture(shown: Any, chosen: argparse.Namespace, lost: list[InputSingularities]) -> Any:
    """Draw the workspace and the singularities of the inputs."""
    if len(chosen.output) == 3:
        return shown.plot()
    ax = shown.plot(chosen.field) if chosen.field else shown.plot(kinds=chosen.curves or KINDS, at=chosen.at)
    return lost[0].plot(ax) if lost else ax


def _interval(
    system: System, chosen: argparse.Namespace, answer: Answer, clock: Clock, **given: Any
) -> WorkspaceRange:
    from ...analyses import workspace_range

    found = workspace_range(system, chosen.output[0], time_limit=clock.left(), **given)
    answer.put(intervals=found.intervals)
    return found


def _area(
    system: System, chosen: argparse.Namespace, answer: Answer, clock: Clock, **given: Any
) -> Workspace:
    from ...analyses import WorkspaceMap
    from ...analyses.workspace.analysis import checked_workspace, reported
    from ...analyses.workspace.problem.watch import POINTS, stopped, watched

    map_ = WorkspaceMap(system, chosen.output, **given)
    with Bar("tracing curves", map_.repeats) as bar:

        def trace() -> None:
            for _ in map_:
                bar.reach(min(map_.in_a_row, map_.repeats))

        with watched(None, done="traced", unit=POINTS, time_limit=clock.left()):
            map_.stop = stopped(trace)
    if map_.stop:
        return reported(map_)
    with Bar("testing the map", 1):
        found = checked_workspace(map_.result(), chosen.samples, time_limit=clock.left())
    if found.success:  # else they are not known
        answer.put(area=found.area, area_error=found.area_error, perimeter=found.perimeter)
        answer.put(parts=[part.area for part in found.components])
    return found


def _volume(
    system: System, chosen: argparse.Namespace, answer: Answer, clock: Clock, **given: Any
) -> WorkspaceVolume:
    from ...analyses import workspace_volume

    given |= {"rtol": chosen.rtol, "samples": chosen.samples, "time_limit": clock.left()}
    found = workspace_volume(system, chosen.output, **given)
    if found.success:
        answer.put(volume=found.volume, volume_error=found.volume_error, critical=found.critical)
    return found


def _write(chosen: argparse.Namespace, found: Any, answer: Answer) -> None:
    """The files that were asked for."""
    for file, method in ((chosen.csv, "to_csv"), (chosen.netcdf, "to_netcdf"), (chosen.view, "view")):
        if file is not None:
            getattr(found, method)(file)
            answer.wrote(file)


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


def _place(text: str) -> tuple[float, float]:
    numbers = [_number(part) for part in text.split(",")]
    if len(numbers) != 2 or None in numbers:
        raise argparse.ArgumentTypeError(f"must be X,Y, but is {text}")
    return numbers[0] or 0.0, numbers[1] or 0.0


def _number(text: str) -> float | None:
    """A number, with a unit if wanted; nothing for no text."""
    from ...model import ModelError, parse_expression

    if not text.strip():
        return None
    try:
        return float(parse_expression(text).value())
    except ModelError as error:
        raise argparse.ArgumentTypeError(f"{text!r}: {error.message}") from None
