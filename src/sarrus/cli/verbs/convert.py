"""``sarrus convert IN OUT``: a model of any format that is read, as a model file or for another program."""

from __future__ import annotations

import argparse

from .. import model_file
from ..answer import Answer
from ..values import EXPORTS, model_out, refuse_unwritable

PURPOSE = "write a model of any format as a model file, or for another program"
EXAMPLES = (
    "sarrus convert crank.yaml crank.json",
    "sarrus convert robot.urdf robot.yaml --base floating",
    "sarrus convert crank.yaml crank.xml --ignore motor",
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """The file of the model, and the file to write."""
    model_file.arguments(
        parser, ignored=f"{model_file.IGNORED}; for another program also parts by their names"
    )
    parser.add_argument(
        "output", type=model_out, help="the file to write: .yaml, .json, or .xml (MJCF), .sdf, .urdf"
    )


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Write the file, from which the same model is read."""
    from ...io import export
    from ...io.robot.options import IGNORABLE
    from ...model import ModelError
    from ...model.show import quote, suggest

    refuse_unwritable([chosen.output])
    parts = [name for name in chosen.ignore if name not in IGNORABLE]
    chosen.ignore = [name for name in chosen.ignore if name in IGNORABLE]
    model = model_file.read(chosen, answer)
    if chosen.output.suffix.lower() in EXPORTS:
        export(model, chosen.output, ignore=parts)
    elif parts:
        raise ModelError(
            f"ignore cannot have {quote(parts[0])} for a model file. {suggest(parts[0], IGNORABLE)}"
        )
    else:
        model.save(chosen.output)
    answer.wrote(chosen.output)
    answer.show(f"{model.headline()}; written to {chosen.output}")
    answer.put(
        model=model.name, output=str(chosen.output), message=f"{model.name}: written to {chosen.output}"
    )
    return 0
