"""A model file with other values in some of its entries: all else, as comments and order, is as it was."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import yaml

from ...checks.origin import Path
from .model_text import scalar_text
from .yaml_document import FAST


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
