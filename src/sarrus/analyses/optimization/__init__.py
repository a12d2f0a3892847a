"""Optimization: designs and parameters that make responses of a motion best, by exact gradients."""

from ..sensitivity.combined import Combined, Composite
from .constraint import Within
from .fit import fit
from .minimize import optimize
from .point import DesignError
from .problem import Problem

__all__ = ["Combined", "Composite", "DesignError", "Problem", "Within", "fit", "optimize"]
