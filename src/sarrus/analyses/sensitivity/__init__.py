"""Sensitivity: exact derivatives of the results of simulations, forward and backward."""

from ...model.deprecated import deprecated_function
from ...outputs import Outputs
from .derivatives import sensitivity, simulated_gradient, state_derivatives
from .hessian import hessian, hessian_product
from .responses.responses import At, AtEvent, Final, Integral, Maximum, Minimum, Misfit, Response

sensitivity_by_checkpoints = deprecated_function(
    "sensitivity_by_checkpoints", "sensitivity(simulate(...), ..., memory=)", simulated_gradient
)

__all__ = [
    "At",
    "AtEvent",
    "Final",
    "Integral",
    "Maximum",
    "Minimum",
    "Misfit",
    "Outputs",
    "Response",
    "hessian",
    "hessian_product",
    "sensitivity",
    "sensitivity_by_checkpoints",
    "state_derivatives",
]
