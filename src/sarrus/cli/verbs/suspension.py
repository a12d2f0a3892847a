"""``sarrus suspension FILE``: the kinematics and compliance of a suspension on a rig."""

from __future__ import annotations

import argparse
from pathlib import Path

from .. import shared
from ..answer import Answer
from ..values import finite, refuse_unwritable

PURPOSE = "analyse a suspension on a rig: toe, camber and other characteristics over bump, roll and steer"
EXAMPLES = (
    "sarrus suspension front.yaml",
    "sarrus suspension front.yaml --sweep roll --figure roll.png --csv roll.csv",
    "sarrus suspension front.yaml --sensitivity ride_steer",
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """The file, the sweep, and what to write."""
    parser.add_argument(
        "rig",
        type=Path,
        help="a .yaml or .json file: model, wheels, bump, roll, steering, steer; a model file with the section rig; or "
        "a shipped suspension, such as macpherson",
    )
    parser.add_argument(
        "--sweep",
        choices=("bump", "roll", "steer"),
        default="bump",
        help="of the table, plot and file (bump)",
    )
    parser.add_argument(
        "--side", choices=("left", "right"), help="of the table and the derivatives (the left one)"
    )
    parser.add_argument("--compliance", action="store_true", help="also the compliance at the wheels")
    parser.add_argument(
        "--sensitivity",
        nargs="+",
        metavar="NAME",
        help="derivatives of characteristics, e.g. ride_steer camber",
    )
    parser.add_argument(
        "--at", type=finite, default=0.0, help="displacement of the derivatives [m], [rad] (0)"
    )
    shared.table(parser, "all curves of the sweep")
    shared.figure(parser, "the sheet of curves")


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Analyse the suspension; 1 if a sweep ends early (what was reached is still written)."""
    from ...io import load_any
    from ...studies.suspension import read_suspension_file
    from ...vehicles.characteristics import SLOPES

    refuse_unwritable([chosen.csv, chosen.figure])
    result = read_suspension_file(chosen.rig, lambda file: answer.noted(load_any(file))).analysed()
    side, sweep = chosen.side or result.sides[0], chosen.sweep
    answer.show(result.table(sweep, side))
    names = result.names(sweep)
    answer.put(
        model=result.name, message=result.message, sweep=sweep, side=side, displacement=result.x(sweep)
    )
    answer.put(curves={name: result.curve(name, sweep, side) for name in names})
    if not result.success:
        answer.show(result.message)
    if chosen.compliance:
        found = result.compliance()
        answer.show(f"\n{found.summary()}")
        answer.put(compliance={name: found.value(name, side) for name in found.names()}, matrix=found.matrix)
    for name in chosen.sensitivity or ():
        gradient = result.sensitivity(name, chosen.at, None if name in SLOPES else sweep, side)
        answer.show(f"\n{gradient.summary()}")
        answer.put(**{name: {"value": gradient.value, "derivatives": dict(gradient)}})
    if chosen.figure:
        answer.draw(result.plot(sweep)[0].figure, chosen.figure)
    if chosen.csv:
        result.to_csv(chosen.csv, sweep)
        answer.wrote(chosen.csv)
    return 0 if result.success else 1
