"""Derivatives of responses by parameters, from sweeps over stored steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...algebra import Array
from .chain.chain import Gradients, Nodes, by_joints
from .events.chains import AnyChain
from .parameters.parameters import Parameters
from .responses.evaluation import Explicit
from .responses.responses import Response


class Derivatives(NamedTuple):
    """First derivatives by parameters (k, p): of responses, if any, and of sums of states, if they were swept."""

    parameters: Parameters
    responses: Sequence[Response]
    of_responses: Array
    of_sums: Array


def adjoint(
    chain: AnyChain, given: tuple[Nodes, Explicit], parameters: Parameters, adjoints: list[Array]
) -> tuple[Array, Array]:
    """Derivatives of responses (k, p), and of sums of states that are swept with them."""
    nodes, explicit = given
    k, by = explicit.b.shape[1], chain.gradients(nodes, adjoints)
    found = by_parameters(by, parameters, explicit)
    return found[:k] + own_parts(explicit, parameters), found[k:]


def by_parameters(by: Gradients, parameters: Parameters, explicit: Explicit | None = None) -> Array:
    """Derivatives by parameters (k, p), with what the first responses depend on by themselves."""
    b, c = by.b.copy(), by_joints(np.zeros((parameters.c_size, by.b.shape[1])), by.c)
    if explicit is not None:
        b[:, : explicit.b.shape[1]] += explicit.b
        c[:, : explicit.c.shape[1]] += explicit.c
    return np.asarray(parameters.gradient(replace(by, b=b), c).T)


def direct(chain: AnyChain, given: tuple[Nodes, Explicit], parameters: Parameters, chosen: Array) -> Array:
    nodes, explicit = given
    b, q, v, c = parameters.along(np.eye(len(parameters.names))[:, chosen])
    total = own_parts(explicit, parameters)
    if not chosen.any():
        return total
    total[:, chosen] += chain.weighed(nodes, b, q, v, c) + explicit.b.T @ b + explicit.c.T @ c
    return total


def own_parts(explicit: Explicit, parameters: Parameters) -> Array:
    """Return the direct derivatives of responses with respect to parameters (r, p)."""
    found = [own.get(name, 0.0) for own in explicit.named for name in parameters.names]
    return np.reshape(found, (len(explicit.named), len(parameters.names)))
