"""Messages of errors, read from the sources: `<part>: <what is wrong>. <What to do>.`, without retired words."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

import sarrus

from .language import retired

SOURCES = Path(sarrus.__file__).parent
ERRORS = {
    "ModelError",
    "SarrusError",
    "ElementError",
    "SavedDataError",
    "NoSavedDataError",
    "FolderTakenError",
    "ValueError",
    "TypeError",
}
REASON = re.compile(
    r"it (is|has|names|places|declares)\b|its "
)  # a defect of a file, whose reader completes the message
UNKNOWN = "{}"  # the value of a variable; it may be the end of the message, as a list of allowed values is


class Message(NamedTuple):
    """A message, and where it is raised."""

    file: str
    line: int
    text: str


def text_of(node: ast.expr, variables: dict[str, list[ast.expr]]) -> str:
    """A message as far as the source determines it."""
    match node:
        case ast.Constant(value=str(text)):
            return text
        case ast.JoinedStr(values=parts):
            return "".join(text_of(part, variables) for part in parts)
        case ast.FormattedValue(value=ast.Name() as name):
            return text_of(name, variables)
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            return text_of(left, variables) + text_of(right, variables)
        case ast.Name(id=name) if len(variables.get(name, ())) == 1:
            return text_of(variables[name][0], {})
    return UNKNOWN


def messages_of(tree: ast.AST, file: str) -> Iterator[Message]:
    """The messages of all errors of ours that a module raises."""
    for function in ast.walk(tree):
        if not isinstance(function, ast.FunctionDef):
            continue
        variables: dict[str, list[ast.expr]] = {}
        nodes = [*ast.walk(function)]
        for node in nodes:
            match node:
                case ast.Assign(targets=[ast.Name(id=name)], value=value):
                    variables.setdefault(name, []).append(value)
        for node in nodes:
            match node:
                case ast.Raise(exc=ast.Call(func=ast.Name(id=name), args=[first, *_])) if name in ERRORS:
                    yield Message(file, node.lineno, text_of(first, variables))
                case ast.Call(func=ast.Name(id="RunFailure"), args=[_, text, *_]):
                    yield Message(file, node.lineno, text_of(text, variables))


def faults(message: Message) -> Iterator[str]:
    """What is wrong with the shape of a message."""
    if re.search(r"; [a-z]", message.text):
        yield "the remedy is a sentence of its own: it follows a full stop"
    if not message.text.endswith((".", "?", UNKNOWN)):
        yield "it ends with a full stop"
    if message.text.endswith(UNKNOWN) and not re.search(r"[.:?}] ([A-Z]|{)|one of {}$|^({})+$", message.text):
        yield "a remedy follows the value"
    if re.match(r"[A-Z][a-z]+ ", message.text):
        yield "it begins with the part"


@pytest.fixture(scope="module")
def messages() -> list[Message]:
    texts = {
        file.relative_to(SOURCES).as_posix(): file.read_text(encoding="utf-8")
        for file in sorted(SOURCES.rglob("*.py"))
        if not file.is_relative_to(SOURCES / "_jit")
    }
    return [
        message
        for file, text in texts.items()
        if "raise " in text or "RunFailure" in text  # others need not be parsed
        for message in messages_of(ast.parse(text), file)
        if not REASON.match(message.text)
    ]


def test_messages_have_the_shape(messages: list[Message]) -> None:
    assert len(messages) > 400
    assert [(*message, fault) for message in messages for fault in faults(message)] == []


def test_no_message_contains_a_retired_word(messages: list[Message]) -> None:
    assert [(*message, word) for message in messages for _, word, _ in retired(message.text)] == []


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("mass: must be positive, got -1. Give it in kg.", 0),
        ("mass: must be positive; give it in kg.", 1),
        ("{}: could not be assembled. Check {}", 0),
        ("rod: is {}. Choose one of {}", 0),
        ("rod must be short, but is {}", 1),
        ("rod must be short, but is {}. Give a length.", 0),
        ("Nothing moves. Add a joint.", 1),
        ("Nothing moves; add a joint", 3),
    ],
)
def test_faults_are_found(text: str, wrong: int) -> None:
    assert len(list(faults(Message("", 1, text)))) == wrong
