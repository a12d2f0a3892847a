"""The command line's grammar: which verbs there are, and what all of them take."""

from __future__ import annotations

import argparse
from collections.abc import Container
from importlib import import_module
from typing import Any, NoReturn

VERBS = {
    "demo": "assemble, check, simulate and plot the shipped slider-crank",
    "run": "assemble and simulate a model file",
    "kinematics": "compute the motion that the drivers of a model file prescribe, and its forces",
    "statics": "find an equilibrium of a model file, with its stability and joint reactions",
    "modes": "print the vibration modes of a model file about its equilibrium",
    "workspace": "map what two outputs of a model can reach, its boundary and barriers",
    "view": "show a model file, or its motion, in the browser",
    "study": "run a model for many values of its parameters, and tabulate the responses",
    "sensitivity": "rank the parameters of a model by their influence on responses of its motion",
    "optimize": "find the optimal parameters of a model, or estimate them from measurements",
    "check": "describe a model in words, and compare every derivative with an independent one",
    "paper": "print the numerical experiments of the paper, Tables 1 to 6",
    "schema": "print the JSON Schema of the model file",
    "completion": "print a script that completes verbs and options in a shell",
}
ENDING = """examples:
  sarrus demo
  sarrus run crank.yaml --until 5 --plot slider.x
  sarrus run --help

exit codes:
  0  success
  1  an analysis failed, and its message gives the reason
  2  the command line, a file or the model is wrong
  3  an internal error of Sarrus
  130 stopped by Ctrl-C
"""


class Misuse(Exception):
    """The command line itself is wrong."""


class Parser(argparse.ArgumentParser):
    """A parser that raises `Misuse` with one message; options of several values may be repeated."""

    def add_argument(self, *names: Any, **options: Any) -> argparse.Action:
        """The same, but that values of a second ``--response`` are added to those of the first."""
        if options.get("nargs") == "+":
            options.setdefault("action", "extend")
        return super().add_argument(*names, **options)

    def error(self, message: str) -> NoReturn:
        """Raise the message, with a reference to the help."""
        raise Misuse(f"{message.replace('argument ', '', 1)}; see {self.prog} --help")


def build(wanted: Container[str]) -> Parser:
    """The parser, with the arguments of the verbs that are wanted: what they import is not paid for by others."""
    from .. import __version__

    parser = Parser(
        "sarrus",
        description="Multibody system analysis with exact derivatives.",
        epilog=ENDING,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"sarrus {__version__}")
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    for verb, purpose in VERBS.items():
        child = verbs.add_parser(
            verb,
            help=purpose,
            description=purpose.capitalize() + ".",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        if verb in wanted:
            module = import_module(f".verbs.{verb}", __package__)
            child.epilog = "examples:\n" + "".join(f"  {line}\n" for line in module.EXAMPLES)
            module.arguments(child)
        _common(child)
    return parser


def _common(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("options of every verb")
    group.add_argument("--json", action="store_true", help="answer with one JSON object, in SI units")
    group.add_argument("--strict", action="store_true", help="end with exit code 1 if there are warnings")
    level = group.add_mutually_exclusive_group()
    level.add_argument(
        "-v", "--verbose", dest="level", action="store_const", const=1, default=0, help="more details"
    )
    level.add_argument(
        "-q", "--quiet", dest="level", action="store_const", const=-1, help="no progress and no notes"
    )
    group.add_argument("--debug", action="store_true", help="show where in the program an error arose")
