"""``sarrus schema``: the JSON Schema of the model file."""

from __future__ import annotations

import argparse


def arguments(parser: argparse.ArgumentParser) -> None:
    """It takes none."""


def run(chosen: argparse.Namespace) -> int:
    """Print the schema."""
    from ..model.file.schema import print_schema

    print_schema()
    return 0
