"""Analyses take a system and give back results."""

from .assembly import assemble
from .ode import ODE
from .simulation import simulate

__all__ = ["ODE", "assemble", "simulate"]
