"""``sarrus schema``: the JSON Schema of the model file."""

from __future__ import annotations

import argparse

from ..answer import Answer

PURPOSE = "print the JSON Schema of the model file"
EXAMPLES = ("sarrus schema > model-schema.json",)


def arguments(parser: argparse.ArgumentParser) -> None:
    """It takes none."""


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    from ...model.file.schema import schema, schema_text

    answer.put(schema=schema())
    answer.show(schema_text().rstrip())
    return 0
