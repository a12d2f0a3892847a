"""Sensitivity: exact derivatives of the results of simulations, forward and backward."""

from ...outputs import Outputs
from .checkpoints import sensitivity_by_checkpoints
from .derivatives import hessian, hessian_product, sensitivity, state_derivatives
from .responses.responses import At, AtEvent, Final, Integral, Maximum, Minimum, Misfit, Peak, Response

__all__ = [
    "At",
    "AtEvent",
    "Final",
    "Integral",
    "Maximum",
    "Minimum",
    "Misfit",
    "Outputs",
    "Peak",
    "Response",
    "hessian",
    "hessian_product",
    "sensitivity",
    "sensitivity_by_checkpoints",
    "state_derivatives",
]
