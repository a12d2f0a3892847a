"""Comparison of two models to the last bit: equations and drawings."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..bodies.shape import Look
from ..expansion.blueprint import Blueprint, Placed, blueprint
from ..model import Model
from ..quantity import is_list


def first_difference(one: Model, other: Model) -> str:
    """Return the name of the first part that differs between two models; nothing if they are the same."""
    a, b = ([*_facts(model)] for model in (one, other))
    both = zip(a, b, strict=False)
    different = next((name for (name, fact), found in both if (name, fact) != found), "")
    return different or ("" if len(a) == len(b) else one.name)


def _facts(model: Model) -> Iterator[tuple[str, Any]]:
    """Yield the name of a part with what must be equal, for every part."""
    plan: Blueprint = blueprint(model)
    yield model.name, (plan.name, plan.bodies, [*model.rates.items()], [*model.parameters.items()])
    yield from ((body, _bits(plan.q[7 * n : 7 * n + 7])) for n, body in enumerate(plan.bodies))
    yield from ((body, _bits(plan.v[7 * n : 7 * n + 7])) for n, body in enumerate(plan.bodies))
    yield from (_placed(one) for one in (*plan.placed, *plan.coordinates))
    yield from (_look(look) for look in Model.looks(model))


def _placed(one: Placed) -> tuple[str, Any]:
    return one.owner, (one.element, one.bodies, one.label, [_bits(value) for value in one.values])


def _look(look: Look) -> tuple[str, Any]:
    pose = _bits(look.pose.r), _bits(look.pose.p)
    return look.body, (look.shape, _bits(look.size), *pose, look.file and look.file.resolve(), look.color)


def _bits(value: Any) -> Any:
    """Return numbers as texts, from which they are read back as they are; those of a curve, too."""
    if hasattr(value, "numbers"):
        return type(value), _bits(value.numbers())
    return [_bits(entry) for entry in value] if is_list(value) else repr(float(value))
