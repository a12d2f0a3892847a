"""Derivatives of responses by parameters, from sweeps over stored steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...algebra import Array
from ...model.announcement import announce
from ...results import Assembly, ErrorEstimate, Gradient
from ..position.assembly_derivatives import AssemblyDerivatives
from .chain.chain import Gradients, Nodes, by_joints
from .parameters.parameters import Parameters
from .parameters.singular_start import singular_start
from .responses.evaluation import DirectTerms
from .responses.responses import Response
from .run_chain import RunChain


def adjoint(
    chain: RunChain,
    given: tuple[Nodes, DirectTerms],
    parameters: Parameters,
    adjoints: list[Array] | None = None,
) -> Array:
    """Derivatives of responses (k, p) by one sweep backward; the adjoints of each segment are appended, if wanted."""
    nodes, explicit = given
    return by_parameters(chain.gradients(nodes, adjoints), parameters, explicit)


def by_parameters(by: Gradients, parameters: Parameters, explicit: DirectTerms) -> Array:
    """Derivatives by parameters (k, p), with what responses depend on by themselves."""
    c = by_joints(np.zeros((parameters.c_size, by.b.shape[1])), by.c) + explicit.c
    total = parameters.gradient(replace(by, b=by.b + explicit.b), c).T
    return np.asarray(total + own_parts(explicit, parameters))


def direct(chain: RunChain, given: tuple[Nodes, DirectTerms], parameters: Parameters, chosen: Array) -> Array:
    """Derivatives of responses (k, p) by a sweep forward for each chosen parameter."""
    nodes, explicit = given
    b, q, v, c = parameters.along(np.eye(len(parameters.names))[:, chosen])
    total = own_parts(explicit, parameters)
    if not chosen.any():
        return total
    total[:, chosen] += chain.weighed(nodes, b, q, v, c) + explicit.b.T @ b + explicit.c.T @ c
    return total


def own_parts(explicit: DirectTerms, parameters: Parameters) -> Array:
    """Return the direct derivatives of responses with respect to parameters (r, p)."""
    found = [own.get(name, 0.0) for own in explicit.named for name in parameters.names]
    return np.reshape(found, (len(explicit.named), len(parameters.names)))


def gradient_of(
    responses: Sequence[Response], parameters: Parameters, start: Assembly, assembly: AssemblyDerivatives,
    values: Array, matrix: Array, missing: Array, errors: Sequence[ErrorEstimate] = (),
) -> Gradient:  # fmt: skip
    """The gradient of responses of a run from a start: NaN for the parameters that have no derivative."""
    announce(singular_start(parameters, start, assembly, missing))
    matrix[:, missing] = np.nan
    system = parameters.system
    return Gradient(
        tuple(one.title for one in responses), tuple(parameters.names), values, parameters.values, matrix,
        tuple(errors), response_units=tuple(one.unit(system) for one in responses), units=parameters.units,
    )  # fmt: skip
