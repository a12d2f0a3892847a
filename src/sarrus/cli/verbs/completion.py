"""``sarrus completion SHELL``: a script that completes verbs, options, their choices and files in a shell."""

from __future__ import annotations

import argparse
from typing import Any

from ..answer import Answer
from ..parser import VERBS, build

PURPOSE = "print a script that completes verbs and options in a shell"
SHELLS = ("bash", "zsh", "fish", "tcsh", "powershell")
EXAMPLES = (
    'eval "$(sarrus completion bash)"                                # in ~/.bashrc',
    'eval "$(sarrus completion zsh)"                                 # in ~/.zshrc, after compinit',
    "sarrus completion fish > ~/.config/fish/completions/sarrus.fish",
)


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("shell", choices=SHELLS)


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    import shtab

    parser = build(VERBS)
    _complete_files(parser)
    script = shtab.complete(parser, chosen.shell)
    answer.show(script)
    answer.put(shell=chosen.shell, script=script)
    return 0


def _complete_files(parser: argparse.ArgumentParser) -> None:
    """Let values without choices be completed as files, as those of verbs are."""
    import shtab

    for action in parser._actions:
        options: Any = action
        if isinstance(action, argparse._SubParsersAction):
            for verb in action.choices.values():
                _complete_files(verb)
        elif action.nargs != 0 and not action.choices:
            options.complete = shtab.FILE
