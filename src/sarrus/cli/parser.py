"""The command line's grammar: its verbs, and the options that all of them take."""

from __future__ import annotations

import argparse
from collections.abc import Container, Sequence
from typing import Any, NoReturn, Protocol

from .answer import Answer


class Verb(Protocol):
    """A module with these names is a verb; slow imports are inside ``run``."""

    PURPOSE: str  # one line for the help
    EXAMPLES: tuple[str, ...]

    def arguments(self, parser: argparse.ArgumentParser) -> None:
        """Declare its arguments."""

    def run(self, chosen: argparse.Namespace, answer: Answer) -> int:
        """Print and store the results, and return the exit code."""


VERBS: dict[str, Verb] = {}  # by name
MEANT = {
    **dict.fromkeys(("simulate", "simulation", "dynamics", "transient", "plot"), "run"),
    **dict.fromkeys(("equilibrium", "static"), "statics"),
    **dict.fromkeys(("vibration", "eigen", "eigenvalues", "linearize"), "modes"),
    **dict.fromkeys(("fit", "estimate", "minimize"), "optimize"),
    **dict.fromkeys(("gradient", "derivatives"), "sensitivity"),
    **dict.fromkeys(("animate", "show", "draw", "open"), "view"),
    **dict.fromkeys(("validate", "verify", "mobility", "info"), "check"),
}  # words of other programs, and of Python
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
        near = self._nearest(message.rpartition("unrecognized arguments: ")[2].partition(" ")[0])
        raise Misuse(f"{message.replace('argument ', '', 1)}. {near}See {self.prog} --help.")

    def _nearest(self, word: str) -> str:
        """The option of a verb that may be meant by an unknown one."""
        if not word.startswith("--"):
            return ""
        from ..model.show import suggest  # with NumPy, which the help does without

        verbs: Any = next((action.choices for action in self._actions if action.dest == "verb"), {})
        known = {
            name
            for one in (self, *verbs.values())
            for action in one._actions
            for name in action.option_strings
        }
        hint = suggest(word.strip("-").partition("=")[0], sorted(name.strip("-") for name in known))
        return hint.replace('"', '"--', 1) + " " if hint.startswith("Did you mean") else ""


def refuse_unknown_verb(words: Sequence[str]) -> None:
    """Raise `Misuse` for a first word that is no verb, with the nearest one, or that of the same meaning."""
    word = words[0] if words else "-"
    if not word.startswith("-") and word not in VERBS:
        from ..model.show import suggest  # with NumPy, which the help does without

        near = f'Did you mean "{MEANT[word]}"?' if word in MEANT else suggest(word, VERBS)
        raise Misuse(f"there is no verb {word!r}. {near} See sarrus --help.")


def build(wanted: Container[str]) -> Parser:
    """The parser of all verbs, with the arguments of those that are wanted: others cost no time."""
    from .. import __version__

    parser = Parser(
        "sarrus",
        description="Multibody system analysis with exact derivatives.",
        epilog=ENDING,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"sarrus {__version__}")
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    for name, verb in VERBS.items():
        child = verbs.add_parser(
            name,
            help=verb.PURPOSE,
            description=verb.PURPOSE.capitalize() + ".",
            epilog="examples:\n" + "".join(f"  {line}\n" for line in verb.EXAMPLES),
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        if name in wanted:
            verb.arguments(child)
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
