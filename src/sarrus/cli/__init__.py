"""The command line: one verb, one analysis."""

from __future__ import annotations

import argparse
import sys
import traceback
from collections.abc import Sequence
from importlib import import_module
from typing import NoReturn

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


class Misuse(Exception):
    """The command line itself is wrong."""


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one sentence, like everything else."""

    def error(self, message: str) -> NoReturn:
        """Raise the sentence, with the way to the help."""
        raise Misuse(f"{message.replace('argument ', '', 1)}; see {self.prog} --help")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one verb; 0 if all went well, 1 if an analysis failed, 2 for wrong input."""
    try:
        return _run(_parser(argv).parse_args(argv))
    except Misuse as misuse:
        return _refuse(str(misuse))


def _parser(argv: Sequence[str] | None) -> Parser:
    from .. import __version__

    parser = Parser("sarrus", description="Multibody system analysis with exact derivatives.")
    parser.add_argument("--version", action="version", version=f"sarrus {__version__}")
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    wanted = next((word for word in (sys.argv[1:] if argv is None else argv) if word in VERBS), None)
    for verb, told in VERBS.items():
        child = verbs.add_parser(verb, help=told, description=told.capitalize() + ".")
        child.add_argument("--debug", action="store_true", help="show where in the program an error arose")
        if verb == wanted:
            import_module(f".{verb}", __name__).arguments(child)
    return parser


def _run(chosen: argparse.Namespace) -> int:
    try:
        return int(import_module(f".{chosen.verb}", __name__).run(chosen))
    except (ImportError, OSError, ValueError, MemoryError, _sarrus_error()) as trouble:
        if chosen.debug:
            traceback.print_exception(trouble)
        return _refuse(_sentence(trouble))
    except KeyboardInterrupt:
        print("sarrus: stopped", file=sys.stderr)
        return 130


def _sarrus_error() -> type[Exception]:
    from ..model.errors import SarrusError

    return SarrusError


def _sentence(trouble: BaseException) -> str:
    if isinstance(trouble, MemoryError):
        return "there is not enough memory; ask for fewer --steps, or take a smaller model"
    if isinstance(trouble, OSError) and trouble.strerror:
        told = f"{trouble.filename}: " if trouble.filename else ""
        return f"{told}{trouble.strerror.lower()}; check the path, its permissions and the space left"
    if isinstance(trouble, ValueError) and not isinstance(trouble, _sarrus_error()):
        return f"{trouble} (--debug shows where)"
    return str(trouble)


def _refuse(told: str) -> int:
    print(f"sarrus: {told}", file=sys.stderr)
    return 2
