"""Optimization: designs and parameters that make responses of a motion best, by exact gradients."""

from .fit import fit
from .minimize import Within, optimize

__all__ = ["Within", "fit", "optimize"]
