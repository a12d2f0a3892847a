"""The command line: one verb, one analysis.

A verb is a module of ``verbs/``, or of a user, see `extensions`.
"""

from __future__ import annotations

import argparse
import logging
import os
import sys
import time
import traceback
from collections.abc import Sequence
from enum import IntEnum

from .._jit.linking.compilation import showing
from ..console import prepare_streams
from . import verbs  # which registers them
from .answer import Answer
from .extensions import load_extensions
from .parser import VERBS as VERBS
from .parser import Misuse, build, refuse_unknown_verb
from .terminal import is_quiet, listen, painted, warnings_to


class Exit(IntEnum):
    """What a command returns; those of signals as shells have them."""

    FAILED = 1
    WRONG = 2
    DEFECT = 3
    STOPPED = 130
    NO_READER = 141


log = logging.getLogger("sarrus.cli")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one verb; 0 if all went well, 1 if an analysis failed, 2 for wrong input, 3 for a defect, 130 for Ctrl-C."""
    words = sys.argv[1:] if argv is None else argv
    prepare_streams()
    try:
        load_extensions()
        refuse_unknown_verb(words)
        chosen = build([word for word in words if word in VERBS][:1]).parse_args(words)
    except Misuse as misuse:
        return _refuse(str(misuse), Exit.WRONG)
    listen(chosen.level)
    answer = Answer(chosen.verb, as_json=chosen.json)
    code = _run(chosen, answer)
    return _closed(answer, code)


def _run(chosen: argparse.Namespace, answer: Answer) -> int:
    began = time.perf_counter()
    try:
        with warnings_to(answer.warn), showing(False if is_quiet() else None):
            code = int(VERBS[chosen.verb].run(chosen, answer))
        if chosen.strict and (count := len(answer.warnings)) and not code:
            code = _refuse(f"--strict does not allow warnings, and there are {count}", Exit.FAILED)
        log.debug("%s took %.2f s", chosen.verb, time.perf_counter() - began)
        return code
    except KeyboardInterrupt:
        print("sarrus: stopped", file=sys.stderr)
        return Exit.STOPPED
    except BrokenPipeError:
        return Exit.NO_READER
    except Exception as error:
        if chosen.debug:
            traceback.print_exception(error)
        message, code = _message(error)
        answer.put(error=message)
        return _refuse(message, code)


def _closed(answer: Answer, code: int) -> int:
    """Print what is left; where nobody reads it (``sarrus ... | head``), end without a word."""
    lost = code == Exit.NO_READER
    try:
        answer.close(code)
        sys.stdout.flush()
    except OSError as error:
        lost = True
        code = Exit.NO_READER if isinstance(error, BrokenPipeError) else _refuse(*_message(error))
    if lost:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return code


def _message(error: Exception) -> tuple[str, int]:
    """Return the message and the exit code of an error."""
    from ..model.errors import SarrusError

    if isinstance(error, SarrusError | ImportError):
        return str(error), Exit.WRONG
    if isinstance(error, MemoryError):
        return "there is not enough memory. Ask for fewer --steps, or take a smaller model.", Exit.WRONG
    if isinstance(error, OSError) and error.strerror:
        problem = f"{error.filename}: " * bool(error.filename) + error.strerror.lower()
        return f"{problem}. Check the path, its permissions and the space left.", Exit.WRONG
    if isinstance(error, ValueError | OSError):
        return f"{error} (--debug shows where)", Exit.WRONG
    problem = f"unexpected {type(error).__name__}: {error}"
    return f"{problem}. This is a defect of Sarrus, please report it with what --debug shows.", Exit.DEFECT


def _refuse(message: str, code: int) -> int:
    print(f"{painted('sarrus:', 'red', sys.stderr)} {message}", file=sys.stderr)
    return code
