"""The command line: one verb, one analysis."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from importlib import import_module

VERBS = {
    "demo": "assemble, check, simulate and plot the shipped slider-crank",
    "run": "assemble and simulate a model file",
    "kinematics": "follow the drivers of a model file, with the forces that this takes",
    "statics": "find where a model file comes to rest, and what its joints bear",
    "modes": "print the vibration modes of a model file about its rest",
    "check": "explain a model in words, and compare every derivative with an independent one",
    "paper": "print the numerical experiments of the paper, Tables 1 to 6",
    "schema": "print the JSON Schema of the model file",
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run one verb; 0 if all went well, 1 if an analysis failed, 2 for wrong input."""
    from .. import __version__

    parser = argparse.ArgumentParser(
        "sarrus", description="Multibody system analysis with exact derivatives."
    )
    parser.add_argument("--version", action="version", version=f"sarrus {__version__}")
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    wanted = next((word for word in (sys.argv[1:] if argv is None else argv) if word in VERBS), None)
    for verb, told in VERBS.items():
        child = verbs.add_parser(verb, help=told, description=told.capitalize() + ".")
        if verb == wanted:
            import_module(f".{verb}", __name__).arguments(child)
    return _run(parser.parse_args(argv))


def _run(chosen: argparse.Namespace) -> int:
    from ..model.errors import SarrusError

    try:
        return int(import_module(f".{chosen.verb}", __name__).run(chosen))
    except (SarrusError, ImportError, OSError) as trouble:
        print(f"sarrus: {trouble}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("sarrus: stopped", file=sys.stderr)
        return 130
