"""``sarrus workspace MODEL``: what outputs of a mechanism can reach, as picture, table and report."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import model_file, shared
from ..answer import Answer
from ..values import figure_file, natural, positive, refuse_unwritable

if TYPE_CHECKING:
    from ...results import InputSingularities, Workspace, WorkspaceField
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
FACTS = {  # of the answer, by the number of outputs
    1: ("intervals",),
    2: ("area", "area_error", "perimeter"),
    3: ("volume", "volume_error", "critical"),
}
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
    from ...model.errors import SarrusError
    from ...results.saving.exported_file import exporting
    from ...system import System

    refuse_unwritable([chosen.figure, chosen.csv, chosen.report, chosen.netcdf, chosen.view, chosen.singular])
    mistake = next(_mistakes(chosen), None)
    if mistake:
        raise SarrusError(mistake)
    system, clock = System(model_file.read(chosen, answer)), Clock(chosen.time_limit)
    given = {"limits": dict(chosen.limit) or "model", "fixed": dict(chosen.fix), "seed": chosen.seed}
    found = _reached(system, chosen, answer, clock, **given)
    lost: list[InputSingularities] = []
    if found.status in ENDED and (chosen.field or chosen.singular):
        announce(
            [f"{system.name}: --field and --singular are left out, since the map ended before its time."]
        )
        chosen.field = chosen.singular = None
    shown = _field(found, chosen, answer, clock) if chosen.field else found
    if chosen.singular:
        lost = _singular(system, chosen, answer, clock, **given)
    if len(chosen.output) > 1:
        answer.draw(_picture(shown, chosen, lost).figure, chosen.figure)
    for file, method in ((chosen.csv, "to_csv"), (chosen.netcdf, "to_netcdf"), (chosen.view, "view")):
        if file is not None:
            getattr(shown, method)(file)
            answer.wrote(file)
    results = [found, *([shown] if chosen.field else []), *lost]
    if chosen.report:
        with exporting(chosen.report) as draft:
            draft.write_text("\n\n".join(map(str, results)) + "\n", encoding="utf-8")
        answer.wrote(chosen.report)
    return 0 if all(one.success for one in results) else 1


def _reached(system: System, chosen: argparse.Namespace, answer: Answer, clock: Clock, **given: Any) -> Any:
    """What the outputs can reach: an interval, an area or a volume, and its facts."""
    from ...analyses.workspace import workspace, workspace_range, workspace_volume

    count = len(chosen.output)
    options: dict[str, Any] = {} if count == 1 else {"samples": chosen.samples}
    if count == 3:
        options["rtol"] = chosen.rtol
    analysis: Any = {1: workspace_range, 3: workspace_volume}.get(count, workspace)
    found = analysis(system, chosen.output, time_limit=clock.left(), **given, **options)
    answer.show(found)
    answer.put(model=system.name, status=found.status, message=found.message)
    if count == 1 or found.success:  # else they are not known
        answer.put(**{name: getattr(found, name) for name in FACTS[count]})
    if count == 2 and found.success:
        answer.put(parts=[part.area for part in found.components])
    return found


def _mistakes(chosen: argparse.Namespace) -> Iterator[str]:
    """Options that only two outputs have, that need others, or that would change nothing."""
    field, count = chosen.field, len(chosen.output)
    for option in ("field", "at", "curves", "inputs", "singular"):
        if getattr(chosen, option) and count != 2:
            yield f"--{option} is for two outputs, not {count}. Leave it out."
    for option in ("at", "curves"):
        if field and getattr(chosen, option):
            yield f"--{option} is for a picture without --field. Leave one of them out."
    if chosen.inputs and not field and not chosen.singular:
        yield "--inputs is for --field and --singular. Add one of them."
    if chosen.view and count == 2:
        yield "--view is for three outputs, not 2. Leave it out."
    for option in ("csv", "netcdf", "view"):
        if getattr(chosen, option) and count == 1:
            yield f"--{option} is for more than one output. Leave it out."
    if chosen.singular and not chosen.inputs:
        yield "--singular needs to know what drives the mechanism. Add --inputs NAME ..."
    if chosen.turn and field != "turn":
        yield "--turn is for --field turn. Add it."
    if field == "turn" and not chosen.turn:
        yield "--field turn needs the name of a rotation. Add --turn NAME, e.g. --turn platform.rotation_z."
    if field not in (None, "turn", "solutions") and not chosen.inputs:
        yield f"--field {field} needs to know what drives it. Add --inputs NAME ..."


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
    from ...analyses import workspace_field

    options = {"turn": chosen.turn, "seed": chosen.seed, "time_limit": clock.left()}
    field = workspace_field(found, chosen.inputs, **options)
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
