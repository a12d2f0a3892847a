"""``sarrus completion SHELL``: a script that completes verbs, options and their choices in bash, zsh or fish."""

from __future__ import annotations

import argparse
from typing import NamedTuple

from ..answer import Answer
from ..parser import VERBS, build

PURPOSE = "print a script that completes verbs and options in a shell"
EXAMPLES = (
    'eval "$(sarrus completion bash)"                                # in ~/.bashrc',
    'eval "$(sarrus completion zsh)"                                 # in ~/.zshrc, after compinit',
    "sarrus completion fish > ~/.config/fish/completions/sarrus.fish",
)


class Option(NamedTuple):
    """An option of a verb: its spellings, whether a value follows, the values if they are few, and its help."""

    names: tuple[str, ...]
    takes_value: bool
    choices: tuple[str, ...]
    description: str


def arguments(parser: argparse.ArgumentParser) -> None:
    """The shell."""
    parser.add_argument("shell", choices=("bash", "zsh", "fish"))


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Print the script."""
    script = {"bash": _bash, "zsh": _zsh, "fish": _fish}[chosen.shell](_options())
    answer.show(script)
    answer.put(shell=chosen.shell, script=script)
    return 0


def _options() -> dict[str, list[Option]]:
    """The options of every verb, read from its parser."""
    parser = build(VERBS)
    (verbs,) = (action for action in parser._actions if isinstance(action, argparse._SubParsersAction))
    return {verb: [_option(a) for a in child._actions] for verb, child in verbs.choices.items()}


def _option(action: argparse.Action) -> Option:
    choices = tuple(str(choice) for choice in action.choices or ())
    return Option(tuple(action.option_strings), action.nargs != 0, choices, action.help or "")


def _words(options: list[Option]) -> str:
    """What may stand anywhere behind a verb."""
    free = [word for option in options if not option.names for word in option.choices]
    return " ".join([*(name for option in options for name in option.names), *free])


def _bash(options: dict[str, list[Option]]) -> str:
    words = "\n".join(f"        {verb}) words={_quoted(_words(known))} ;;" for verb, known in options.items())
    choices = "\n".join(
        f"        '{verb} {name}') words='{' '.join(option.choices)}'; values=1 ;;"
        for verb, known in options.items()
        for option in known
        for name in option.names
        if option.choices
    )
    return f"""_sarrus() {{
    local verb="${{COMP_WORDS[1]}}" word="${{COMP_WORDS[COMP_CWORD]}}" before="${{COMP_WORDS[COMP_CWORD-1]}}"
    local words='' values=''
    COMPREPLY=()
    if [ "$COMP_CWORD" -eq 1 ]; then
        COMPREPLY=($(compgen -W '{" ".join(options)} --help --version' -- "$word"))
        return
    fi
    case "$verb" in
{words}
    esac
    case "$verb $before" in
{choices}
    esac
    if [ -n "$values" ] || [[ "$word" == -* ]] || [ "$verb" = completion ]; then
        COMPREPLY=($(compgen -W "$words" -- "$word"))
    fi
}}
complete -o default -F _sarrus sarrus"""


def _zsh(options: dict[str, list[Option]]) -> str:
    verbs = "\n".join(f"        {_quoted(f'{verb}:{VERBS[verb].PURPOSE}')}" for verb in options)
    cases = "\n".join(
        f"        {verb}) _arguments {' '.join(_zsh_option(option) for option in known)} ;;"
        for verb, known in options.items()
    )
    return f"""#compdef sarrus
_sarrus() {{
    local -a verbs
    verbs=(
{verbs}
    )
    if (( CURRENT == 2 )); then
        _describe verb verbs
        return
    fi
    local verb="$words[2]"
    shift words
    (( CURRENT-- ))
    case "$verb" in
{cases}
    esac
}}
compdef _sarrus sarrus"""


def _zsh_option(option: Option) -> str:
    values = f"({' '.join(option.choices)})" if option.choices else "_files"
    if not option.names:
        return _quoted(f"*:value:{values}")
    description = option.description.translate(str.maketrans("[]:", "() "))
    tail = f":value:{values}" if option.takes_value else ""
    return " ".join(_quoted(f"{name}[{description}]{tail}") for name in option.names)


def _fish(options: dict[str, list[Option]]) -> str:
    lines = [
        f"complete -c sarrus -n __fish_use_subcommand -f -a {verb} -d {_quoted(VERBS[verb].PURPOSE)}"
        for verb in options
    ]
    for verb, known in options.items():
        lines += [
            f"complete -c sarrus -n '__fish_seen_subcommand_from {verb}' {_fish_option(o)}" for o in known
        ]
    return "\n".join(lines)


def _fish_option(option: Option) -> str:
    spelled = " ".join(f"-l {n[2:]}" if n.startswith("--") else f"-s {n[1:]}" for n in option.names)
    values = f"-a {_quoted(' '.join(option.choices))}" if option.choices else ""
    follows = "-r" if option.names and option.takes_value else ""
    return " ".join(part for part in (spelled, follows, values, f"-d {_quoted(option.description)}") if part)


def _quoted(text: str) -> str:
    """In single quotes, for any of the three shells."""
    return "'" + text.replace("'", "’") + "'"
