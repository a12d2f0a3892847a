"""A model with other values of its inputs."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

from ..errors import ModelError
from ..model import Model
from ..show import quote, suggest
from .input import Input


def refuse_unknown_input(owner: str, name: Any, known: Collection[str]) -> None:
    """Refuse a name that is none of the inputs of a model.

    Raises
    ------
    ModelError
    """
    if name not in known:
        near = suggest(str(name), known) if known else 'Add sr.Input("u", 0.0) to its forces.'
        raise ModelError(f"{owner} has no input {quote(str(name))}. {near}")


def refuse_repeated_inputs(owner: str, names: Sequence[str]) -> None:
    """Refuse a list that names an input more than once.

    Raises
    ------
    ModelError
    """
    for name in names:
        if names.count(name) > 1:
            raise ModelError(f"{owner}: inputs contains {quote(name)} more than once. Name each input once.")


def with_input_values(model: Model, values: Mapping[str, Any]) -> Model:
    """Return the model with other values of inputs by name; they no longer follow from parameters of its file.

    Raises
    ------
    ModelError
        If it has no input of a name.
    """
    own = {force.name for force in model.forces if isinstance(force, Input)}
    for name in values:
        refuse_unknown_input(model.name, name, own)
    forces = [
        replace(force, value=values[force.name])
        if isinstance(force, Input) and force.name in values
        else force
        for force in model.forces
    ]
    gone = {("forces", name, "value") for name in values}
    expressions = {path: x for path, x in model.formulas.expressions.items() if path[:3] not in gone}
    return replace(model, forces=forces, formulas=replace(model.formulas, expressions=expressions))
