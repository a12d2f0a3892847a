"""Analyses take a system and give back results."""

from .assembly import assemble
from .joint_space import JointSpace
from .ode import ODE
from .simulation import simulate

__all__ = ["ODE", "JointSpace", "assemble", "simulate"]
