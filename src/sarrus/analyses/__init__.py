"""Analyses take a system and give back results."""

from .assembly import assemble
from .assembly_derivatives import AssemblyDerivatives, NoDerivative
from .degrees_of_freedom import mobility
from .ode import ODE
from .simulation import simulate
from .singular_positions import singularities

__all__ = ["ODE", "AssemblyDerivatives", "NoDerivative", "assemble", "mobility", "simulate", "singularities"]
