"""``sarrus convert IN OUT``: a model of any format that is read, as a model file."""

from __future__ import annotations

import argparse

from .. import model_file
from ..answer import Answer
from ..values import model_out, refuse_unwritable

PURPOSE = "write a model of any format as a YAML or JSON model file"
EXAMPLES = (
    "sarrus convert crank.yaml crank.json",
    "sarrus convert robot.urdf robot.yaml --base floating",
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """The file of the model, and the file to write."""
    model_file.arguments(parser)
    parser.add_argument("output", type=model_out, help="the model file to write, .yaml or .json")


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Write the file, from which the same model is read."""
    refuse_unwritable([chosen.output])
    model = model_file.read(chosen)
    model.save(chosen.output)
    answer.wrote(chosen.output)
    answer.show(f"{model.headline()}; written to {chosen.output}")
    answer.put(
        model=model.name, output=str(chosen.output), message=f"{model.name}: written to {chosen.output}"
    )
    return 0
