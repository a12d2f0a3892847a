"""Analyses take a system and give back results."""

from .assembly import assemble
from .dynamics import HHT, ODE, GeneralizedAlpha, simulate

__all__ = ["HHT", "ODE", "GeneralizedAlpha", "assemble", "simulate"]
