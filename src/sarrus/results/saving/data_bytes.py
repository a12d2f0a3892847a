"""Data as bytes: one line of JSON, then the numbers of its arrays. Reading them runs no code."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Mapping
from dataclasses import fields
from math import prod
from types import MappingProxyType
from typing import Any

import numpy as np

from ...algebra import Array
from ...model import SarrusError
from .checked_file import SavedDataError

NUMBERS = "biufU"  # kinds of arrays: no objects
Kinds = Mapping[str, Any]  # dataclasses by name, which are stored by their fields


def dumps(value: Any, known: Kinds, functions: Mapping[str, Any] = MappingProxyType({})) -> bytes:
    """Return the bytes of a value.

    Functions and objects of other classes are not stored but named: as in `functions`, or by their own names.
    """
    arrays: list[Array] = []
    names = {id(function): name for name, function in functions.items()}
    text = json.dumps(_tree(value, known, names, arrays))
    return b"".join([text.encode(), b"\n", *(array.tobytes() for array in arrays)])


def _tree(value: Any, known: Kinds, names: Mapping[int, str], arrays: list[Array]) -> Any:
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.ndarray) and value.dtype.kind in NUMBERS:
        arrays.append(value)
        return {"array": [value.dtype.str, value.shape]}
    if isinstance(value, list | tuple):
        return [_tree(one, known, names, arrays) for one in value]
    if isinstance(value, Mapping):
        return {"mapping": {str(key): _tree(one, known, names, arrays) for key, one in value.items()}}
    name = type(value).__name__
    if known.get(name) is type(value):
        own = {one.name: getattr(value, one.name) for one in fields(known[name]) if one.init}
        return {name: {key: _tree(one, known, names, arrays) for key, one in own.items()}}
    return {"function": names.get(id(value), getattr(value, "__name__", name))}


def loads(source: object, content: bytes, known: Kinds, function: Callable[[str], Any]) -> Any:
    """Return the value of such bytes, with tuples for lists.

    Parameters
    ----------
    source : where they are from, for messages
    function : returns the function of a name

    Raises
    ------
    SavedDataError
        If they are not of this state of Sarrus.
    """
    text, _, numbers = content.partition(b"\n")
    try:
        return _value(json.loads(text), known, io.BytesIO(numbers), function)
    except SarrusError:
        raise
    except Exception as wrong:
        message = f"{source}: cannot be opened ({type(wrong).__name__}: {wrong})."
        remedy = (
            "Another state of Sarrus wrote it. Open it with load_run, install that state, or simulate anew."
        )
        raise SavedDataError(f"{message} {remedy}") from None


def _value(tree: Any, known: Kinds, numbers: io.BytesIO, function: Callable[[str], Any]) -> Any:
    if isinstance(tree, list):
        return tuple(_value(one, known, numbers, function) for one in tree)
    if not isinstance(tree, dict):
        return tree
    ((kind, own),) = tree.items()
    if kind == "array":
        dtype, shape = np.dtype(own[0]), own[1]
        if dtype.kind not in NUMBERS:
            raise TypeError(dtype)
        return np.frombuffer(numbers.read(prod(shape) * dtype.itemsize), dtype).reshape(shape).copy()
    if kind == "function":
        return function(own)
    values = {key: _value(one, known, numbers, function) for key, one in own.items()}
    return values if kind == "mapping" else known[kind](**values)
