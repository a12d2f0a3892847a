"""A model in words."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ..console import printable
from ..elements import EccentricInertia, RigidInertia
from .coordinates import slice_of
from .drivers import Driver
from .errors import listed
from .expansion.blueprint import Blueprint, blueprint
from .forces import Force
from .geometry.rotation import matrix
from .joints import Joint
from .model import Model
from .quantity import Array, vector
from .registry import kind_name
from .show import MOST


def describe(model: Model, *findings: str) -> str:
    """Describe a model as text: parts, initial rates, degrees of freedom, mass, centre of mass.

    Parameters
    ----------
    model
        It is checked on the way.
    findings
        Further messages of analyses, such as which equations are redundant; they follow the degrees of freedom.

    Raises
    ------
    ModelError
        If anything is wrong in the model.
    """
    plan = blueprint(model)
    lines = [
        _title(model),
        _bodies(plan),
        *_parts("joint", model.joints, plan),
        *(_parts("driver", model.drivers, plan) if model.drivers else ()),
        *_parts("force", model.forces, plan),
        *_rates(model),
        _freedom(plan),
        *findings,
        *_parameters(model),
    ]
    return printable("\n".join(line for line in lines if line))


def mass_and_center(plan: Blueprint) -> tuple[float, Array]:
    """Return the mass of all bodies [kg] and their common centre of mass in the initial pose. (3,) [m]"""
    masses, centers = [], []
    for one in plan.placed:
        if issubclass(one.element, RigidInertia | EccentricInertia):
            fields = dict(zip(one.element.fields, one.values, strict=True))
            masses.append(fields["mass"])
            centers.append(global_point(plan, one.bodies[0], fields.get("center", (0.0, 0.0, 0.0))))
    return float(sum(masses)), np.average(centers, axis=0, weights=masses)


def global_point(plan: Blueprint, body: int, local: Iterable[float]) -> Array:
    """Return the global place in the initial pose of a point of body number ``body``. (3,) [m]"""
    if body == 0:
        return np.array([*local], dtype=float)
    q = plan.q[slice_of(body - 1)]
    return np.asarray(q[:3] + matrix(q[3:]) @ np.array([*local], dtype=float))


def _title(model: Model) -> str:
    where = f", from {model.origin.file}" if model.origin else ""
    gravity = vector(model.gravity, "gravity")
    weight = f"gravity {_triple(gravity)} m/s²" if any(gravity) else "no gravity"
    return f"{model.name}{where}; {weight}"


def _bodies(plan: Blueprint) -> str:
    mass, center = mass_and_center(plan)
    text = f"{_count(len(plan.bodies), 'body', 'bodies')}: {_listed(plan.bodies)}"
    return f"{text}; {mass:.6g} kg in all, centre of mass at {_triple(center)} m"


def _parts(word: str, parts: Sequence[Joint | Driver | Force], plan: Blueprint) -> list[str]:
    """Return a line with the number of parts, and one for each type."""
    kinds: dict[str, list[str]] = {}
    for part in parts:
        kinds.setdefault(kind_name(type(part)), []).append(part.name)
    names_of_all = {part.name for part in parts}
    rows = sum(one.element.rows for one in plan.placed if one.owner in names_of_all)
    count = len(parts)
    equations = f", {_count(rows, 'equation')}" if rows else ""
    head = f"{_count(count, word)}{equations}:" if count else f"no {word}s"
    return [head, *(f"  {len(names)} {kind}: {_listed(names)}" for kind, names in kinds.items())]


def _rates(model: Model) -> list[str]:
    """Return the initial rates of joints, if there are any."""
    text = [f"{name} = {float(rate):.6g}" for name, rate in model.rates.items()]
    return [f"initial {'rate' if len(text) == 1 else 'rates'} [rad/s, m/s]: {_listed(text)}"] if text else []


def _freedom(plan: Blueprint) -> str:
    """Return the count of degrees of freedom, as it is when no equation is redundant."""
    rows = sum(one.element.rows for one in plan.placed if one.owner)  # none of states
    others = sum(
        len(kind.parts) for kinds in plan.owners.values() if kinds[0].name == "modal" for kind in kinds
    )
    free = 6 * len(plan.bodies) + others - rows
    text = f"6 × {len(plan.bodies)}{f' + {others}' * (others > 0)} − {rows} = {free}"
    if free < 0:
        return f"degrees of freedom: {text}; there are redundant equations, or it cannot move"
    return f"degrees of freedom: {text}, if no equation is redundant"


def _parameters(model: Model) -> list[str]:
    if not model.parameters:
        return []
    text = [f"{name} = {value:.6g}" for name, value in model.parameters.items()]
    given = [path for path in model.expressions if path[0] != "parameters"]
    formulas = f"{_count(len(given), 'number')} given by formulas"
    return [f"{_count(len(text), 'parameter')} in SI units: {_listed(text)}; {formulas}"]


def _count(number: int, one: str, many: str = "") -> str:
    return f"{number} {one if number == 1 else many or one + 's'}"


def _listed(names: Iterable[str]) -> str:
    given = list(names)
    return listed(given, most=MOST)


def _triple(values: Iterable[float]) -> str:
    return f"({', '.join(f'{value + 0.0:.4g}' for value in values)})"
