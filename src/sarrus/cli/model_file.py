"""The model that a verb works on: its file, and how a robot description is to be read."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from .values import assignment

if TYPE_CHECKING:
    from ..model import Expression, Model
    from .answer import Answer

IMPORT_OPTIONS = ("base", "mimic", "inertia", "loops", "meshes", "search", "ignore", "parameters")


IGNORED = "what an import leaves out although it changes the motion, e.g. flex plugins tendons"


def arguments(parser: argparse.ArgumentParser, *, optional: bool = False, ignored: str = IGNORED) -> None:
    """The file, which may be optional, and the options of an import."""
    parser.add_argument(
        "model",
        nargs="?" if optional else None,
        help="a .yaml or .json model file, a .urdf, .sdf or MJCF .xml, or slider_crank, hmmwv or car (shipped)",
    )
    parser.add_argument(
        "--base",
        choices=("file", "fixed", "floating"),
        help="root links of a robot (as in the file; fixed in a URDF)",
    )
    parser.add_argument(
        "--mimic", choices=("couple", "free", "lock"), help="joints that follow another (couple)"
    )
    parser.add_argument("--inertia", choices=("check", "given"), help="of imported links (check)")
    parser.add_argument(
        "--rate",
        nargs="+",
        default=[],
        type=_rate,
        metavar="JOINT=VALUE",
        help="initial rates of joints, e.g. pin=5 or pin='50 rpm' or slide='0.2 m/s'",
    )
    parser.add_argument(
        "--set",
        nargs="+",
        default=[],
        type=assignment,
        dest="parameters",
        metavar="NAME=VALUE",
        help="parameters of the model file, e.g. stroke='80 mm' crank.mass=2",
    )
    parser.add_argument("--loops", help="file of joints and forces that an imported robot lacks")
    parser.add_argument(
        "--meshes", choices=("draw", "ignore"), help="visuals of a robot that are meshes (draw)"
    )
    parser.add_argument(
        "--search", nargs="+", metavar="FOLDER", help="folders of the packages and models that a robot names"
    )
    parser.add_argument("--ignore", nargs="+", default=[], metavar="NAME", help=ignored)


def read(chosen: argparse.Namespace, answer: Answer) -> Model:
    """Return the model, with the notes of its import in the answer; only what was asked for is handed to the reader."""
    from .. import mechanisms
    from ..io import load_any

    file = chosen.model
    if file in mechanisms.names() and not Path(file).exists():
        file = mechanisms.path(file)
    options = {name: getattr(chosen, name) for name in IMPORT_OPTIONS}
    options["parameters"] = dict(chosen.parameters)
    model = answer.noted(load_any(file, **{name: value for name, value in options.items() if value}))
    return _with_rates(model, dict(chosen.rate)) if chosen.rate else model


def _with_rates(model: Model, formulas: dict[str, Expression]) -> Model:
    """The model with further initial rates."""
    from ..model.expansion.expand import expand
    from ..model.expansion.mappings import check_units

    check_units(expand(model), formulas, None)
    rates = {name: float(tree.value()) for name, tree in formulas.items()}
    return replace(model, rates={**model.rates, **rates})


def _rate(text: str) -> tuple[str, Expression]:
    from ..model import ModelError, parse_expression

    name, equals, value = text.partition("=")
    try:
        if equals:
            return name.strip(), parse_expression(value)
    except ModelError as error:
        raise argparse.ArgumentTypeError(f"{text!r}: {error.message}") from None
    raise argparse.ArgumentTypeError(f"must be JOINT=VALUE, but is {text}")
