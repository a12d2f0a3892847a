"""Analyses take a system and give back results."""

from .assembly import assemble
from .dynamics import HHT, ODE, GeneralizedAlpha, simulate
from .joint_space import JointSpace

__all__ = ["HHT", "ODE", "GeneralizedAlpha", "JointSpace", "assemble", "simulate"]
