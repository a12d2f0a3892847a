"""Mutations of texts, of data, of XML and of bytes; all random choices come from one generator."""

from __future__ import annotations

import copy
import json
import re
from random import Random
from typing import Any
from xml.etree import ElementTree

import yaml

NUMBERS = (
    "0", "-1", "-0.0", "nan", ".nan", "inf", ".inf", "-1e308", "1e308", "1e999", "1e-320", "1e-9", "1e12",
    "9" * 400, "0x10",
    "1_000", "", "null", "true", "[]", "{}", "[1, 2]", "{a: 1}", "text", "5 kg", "3 parsec", "2*pi", "1/0",
    "0/0", "(-1)^0.5", "${x}",
    "${", "x +", "t", "sin(t)", "a" * 300, "é", "\u0000", "\U0001f600", "!!python/object:os.system", "*a",
    "&a 1", "- 1", "#", "'",
)  # fmt: skip
DATA: tuple[Any, ...] = (
    0, -1.0, 1e308, -1e308, 1e-320, 1e-12, 10**400, float("nan"), float("inf"), True, False, None, "",
    "text", "2*pi", "1/0", "t",
    "${rod.mass}", "5 kg", "nan", [], {}, [0, 0, 0], [1, 0, 0], [[1, 2], [3, 4]], [None], ["a"], {"a": 1},
    {"": None}, "ground",
    "simulate", {"from": 0, "to": 1, "count": 3}, {"type": "simulate", "until": 0.01}, "../../etc/passwd",
    [1] * 50, "x" * 5000,
)  # fmt: skip
NUMBER = re.compile(r"(?<![\w.])-?\d+\.?\d*(?:[eE][-+]?\d+)?")
WORD = re.compile(r"[A-Za-z_][\w-]*")


def mutated(data: bytes, kind: str, random: Random) -> bytes:
    """A file's content after one to three mutations."""
    for _ in range(random.choice((1, 1, 1, 2, 3))):
        data = _once(data, kind, random)
    return data


def _once(data: bytes, kind: str, random: Random) -> bytes:
    ways = {"yaml": _tree, "json": _tree, "xml": _element}.get(kind)
    if ways is not None and random.random() < 0.5:
        try:
            return ways(data.decode(), kind, random)
        except (
            ValueError,
            RecursionError,
            AttributeError,
            IndexError,
            OverflowError,
            TypeError,
            yaml.YAMLError,
            ElementTree.ParseError,
        ):
            pass  # it is not well-formed any more
    if kind == "binary" or random.random() < 0.1:
        return _bytes(bytearray(data), random)
    return _text(data.decode(errors="replace"), random).encode(errors="replace")


def _text(text: str, random: Random) -> str:
    way = random.randrange(7)
    lines = text.splitlines(keepends=True) or [""]
    k = random.randrange(len(lines))
    if way == 0:
        return "".join(lines[:k] + lines[k + 1 :])
    if way == 1:
        return "".join(lines[:k] + [lines[random.randrange(len(lines))]] + lines[k:])
    if way == 2:
        return text[: random.randrange(len(text) + 1)]
    if way == 3:
        at = random.randrange(len(text) + 1)
        return text[:at] + random.choice((*"[]{}:,-#&*!|>'\"<>/=\t\n", *NUMBERS)) + text[at:]
    if way in (4, 5):
        return _replaced(text, NUMBER, random.choice(NUMBERS), random)
    words = WORD.findall(text) or ["a"]
    return _replaced(text, WORD, random.choice((random.choice(words), random.choice(words)[:-1], "")), random)


def _replaced(text: str, pattern: re.Pattern[str], new: str, random: Random) -> str:
    found = [*pattern.finditer(text)]
    if not found:
        return text + new
    one = random.choice(found)
    return text[: one.start()] + new + text[one.end() :]


def _bytes(data: bytearray, random: Random) -> bytes:
    way, at = random.randrange(5), random.randrange(len(data) + 1)
    if way == 0:
        return bytes(data[:at])
    if way == 1 and data:
        data[at % len(data)] ^= 1 << random.randrange(8)
    elif way == 2:
        data[at : at + 4] = random.choice((0, 1, 2**31 - 1, 2**31, 2**32 - 1)).to_bytes(4, "little")
    elif way == 3:
        data[at : at + random.randrange(64)] = bytes(random.randrange(64))
    else:
        data[at:at] = data[: random.randrange(64)]
    return bytes(data)


def _places(data: Any) -> list[tuple[Any, Any]]:
    """Every mapping or list in the data with each of its keys."""
    keys = list(data) if isinstance(data, dict) else range(len(data)) if isinstance(data, list) else []
    return [place for key in keys for place in ((data, key), *_places(data[key]))]


def _tree(text: str, kind: str, random: Random) -> bytes:
    data = json.loads(text) if kind == "json" else yaml.safe_load(text)
    places = _places(data)
    holder, key = random.choice(places)
    other, name = random.choice(places)
    way = random.randrange(5)
    if way == 0:
        del holder[key]
    elif way == 1:
        holder[key] = copy.deepcopy(other[name])
    elif way == 2 and isinstance(holder, dict):
        holder[random.choice(("", "type", "a", str(name), f"{key}s"))] = holder.pop(key)
    elif isinstance(holder[key], int | float) and not isinstance(holder[key], bool) and way == 3:
        holder[key] *= random.choice((-1, 0, 1e-9, 1e9, 1e300))
    else:
        holder[key] = copy.deepcopy(random.choice(DATA))
    return json.dumps(data).encode() if kind == "json" else yaml.safe_dump(data, sort_keys=False).encode()


def _element(text: str, kind: str, random: Random) -> bytes:
    root = ElementTree.fromstring(text)
    elements = [*root.iter()]
    one, other = random.choice(elements), random.choice(elements)
    way = random.randrange(5)
    if way == 0 and len(one):
        one.remove(random.choice([*one]))
    elif way == 1:
        one.append(copy.deepcopy(other))
    elif way == 2:
        one.tag = other.tag
    elif one.attrib:
        name = random.choice([*one.attrib])
        if way == 3:
            values = [v for e in elements for v in e.attrib.values()]
            one.attrib[name] = random.choice(values)
        else:
            one.attrib[name] = random.choice(
                ("", "nan", "-1", "1e308", "0 0 0", "1 0", "inf inf inf", "0", "a", "../../x")
            )
    return ElementTree.tostring(root)
