"""Optimization: designs and parameters that make responses of a motion best, by exact gradients."""

from ..sensitivity.combined import Combined, Outer
from .constraint import Within
from .fit import fit
from .minimize import optimize
from .point import Infeasible
from .problem import Problem

__all__ = ["Combined", "Infeasible", "Outer", "Problem", "Within", "fit", "optimize"]
