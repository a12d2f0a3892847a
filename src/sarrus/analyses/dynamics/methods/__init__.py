"""Implicit methods as data, see `description`, and what follows from it for a run. No algorithm lives here."""

from .description import Description, Equation, Estimate, Stage, Step
from .registry import integration_method

__all__ = ["Description", "Equation", "Estimate", "Stage", "Step", "integration_method"]
