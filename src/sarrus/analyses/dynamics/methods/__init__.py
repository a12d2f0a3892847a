"""Implicit methods as data, see `description`, and what follows from it for a run. No algorithm lives here."""

from ...integration_methods import integration_method
from .description import Description, Equation, Estimate, Stage, Step

__all__ = ["Description", "Equation", "Estimate", "Stage", "Step", "integration_method"]
