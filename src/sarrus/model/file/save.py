"""Saving of a model as a model file, from which the same model is read."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path as FilePath
from typing import Any

import yaml

from ...deferred import exporter
from ..bodies.shape import Look
from ..checks.arguments import checked
from ..checks.findings import Path
from ..coordinates import slice_of
from ..errors import ModelError, SarrusWarning
from ..expansion.blueprint import Blueprint, Placement, blueprint
from ..expression import Expression, Number
from ..model import Model
from ..quantity import is_list
from ..show import quote
from .load import load, loaded, parsed
from .plain_data import in_unit, plain_data
from .replaced_file import replacing
from .text.model_text import json_text, scalar_text, yaml_text
from .text.source import SUFFIXES, read_text
from .text.yaml_document import FAST


@checked
def save(model: Model, path: str | os.PathLike[str]) -> None:
    """Write a model to a file; see `Model.save`."""
    file = FilePath(path)
    if file.suffix.lower() not in SUFFIXES:
        exporter()(model, file)
        return
    blueprint(model)  # a model that is wrong is refused
    text = _revised(model, file)
    if text is None:
        data = plain_data(model, file.parent)
        text = json_text(data) if file.suffix.lower() == ".json" else yaml_text(data)
        if part := first_difference(model, loaded(parsed(text, file))):
            message = "is not the same when it is read back from a model file. Build it in Python."
            raise ModelError(message, part=quote(part))
    _replace(file, text)
    if left_out := model.unwritten():
        message = (
            f"{model.name}: {', '.join(left_out)} are not in {file.name}, since model files do not have them."
        )
        warnings.warn(message, SarrusWarning, stacklevel=4)


def _revised(model: Model, file: FilePath) -> str | None:
    """Return the text of the file that the model is from, with changed values; None if more than values changed."""
    origin = FilePath(model.origin.file) if model.origin else None
    if origin is None or (origin.suffix == ".json") != (file.suffix == ".json"):
        return None
    with suppress(ModelError):
        before = load(origin)
        old, new = (plain_data(one, file.parent, complete=True) for one in (before, model))
        trees = before.formulas.expressions
        changed = {path: _in_unit(trees.get(path), value) for path, value in _changes(old, new, ())}
        text = edited(read_text(origin), changed, model.name)
        if text is not None and not first_difference(model, loaded(parsed(text, file))):
            return text
    return None


def _changes(old: Any, new: Any, path: Path) -> Iterator[tuple[Path, Any]]:
    """Yield the path and the new value of every entry that changed.

    Raises
    ------
    ModelError
        If entries were added or removed.
    """
    if isinstance(old, dict) and isinstance(new, dict) and [*old] == [*new]:
        for key in old:
            yield from _changes(old[key], new[key], (*path, key))
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for n, values in enumerate(zip(old, new, strict=True)):
            yield from _changes(*values, (*path, n))
    elif isinstance(old, dict | list) or isinstance(new, dict | list):
        raise ModelError("has other entries. Write the whole file.")
    elif repr(old) != repr(new):
        yield path, new


def _in_unit(tree: Expression | None, value: Any) -> Any:
    """Return a number in the unit that the file has it in, with the fewest digits that give all of its bits."""
    if not isinstance(tree, Number) or not tree.written or isinstance(value, str) or not tree.number:
        return value
    unit = tree.written.partition(" ")[2]
    return (in_unit(value, unit) if unit else "") or value


def _replace(file: FilePath, text: str) -> None:
    """Write a file in one step, so that never half of it is there."""
    try:
        with replacing(file) as draft:
            draft.write_text(text, encoding="utf-8")
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise ModelError(
            f"cannot be written, {reason}. Check the path and its permissions.", where=str(file)
        ) from None


def first_difference(one: Model, other: Model) -> str:
    """Return the name of the first part that differs between two models; nothing if they are the same."""
    a, b = ([*_facts(model)] for model in (one, other))
    both = zip(a, b, strict=False)
    different = next((name for (name, fact), found in both if (name, fact) != found), "")
    return different or ("" if len(a) == len(b) else one.name)


def _facts(model: Model) -> Iterator[tuple[str, Any]]:
    """Yield the name of a part with what must be equal, for every part."""
    plan: Blueprint = blueprint(model)
    yield (
        model.name,
        (plan.name, plan.bodies, [*model.rates.items()], [*model.parameters.items()], dict(model.outputs)),
    )
    yield from ((body, _bits(plan.q[slice_of(n)])) for n, body in enumerate(plan.bodies))
    yield from ((body, _bits(plan.v[slice_of(n)])) for n, body in enumerate(plan.bodies))
    yield from (_placed(one) for one in (*plan.placed, *plan.coordinates))
    yield from (_look(look) for look in Model.looks(model))


def _placed(one: Placement) -> tuple[str, Any]:
    return one.owner, (one.element, one.bodies, one.label, [_bits(value) for value in one.values])


def _look(look: Look) -> tuple[str, Any]:
    pose = _bits(look.pose.r), _bits(look.pose.p)
    return look.body, (look.shape, _bits(look.size), *pose, look.file and look.file.resolve(), look.color)


def _bits(value: Any) -> Any:
    """Return numbers as texts, from which they are read back as they are; those of a curve, too."""
    if hasattr(value, "numbers"):
        return type(value), _bits(value.numbers())
    return [_bits(entry) for entry in value] if is_list(value) else repr(float(value))


def edited(text: str, new: Mapping[Path, Any], name: str) -> str | None:
    """Return a YAML or JSON text with other numbers and texts at some paths, and with a name if it has none.

    None if an entry is not written at its path, as where an alias replaces it. Parts that are not in the text, such as
    the carrier of a moving point, follow from those that are.
    """
    root = yaml.compose(text, Loader=FAST)
    places = dict(_scalars(root, ()))
    parts = {path[:2] for path in places}
    changed = [path for path in new if path[:2] in parts]
    if not places.keys() >= {*changed} or not isinstance(root, yaml.MappingNode):
        return None
    for path in sorted(changed, key=lambda path: -places[path].start_mark.index):
        node = places[path]
        text = text[: node.start_mark.index] + scalar_text(new[path]) + text[node.end_mark.index :]
    if ("name",) in places or root.flow_style:
        return text
    first = root.start_mark.index
    return f"{text[:first]}name: {scalar_text(name)}\n{text[first:]}"


def _scalars(node: Any, path: Path) -> Iterator[tuple[Path, Any]]:
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            yield from _scalars(value, (*path, str(key.value)))
    elif isinstance(node, yaml.SequenceNode):
        for n, value in enumerate(node.value):
            yield from _scalars(value, (*path, n))
    else:
        yield path, node
