"""Analyses take a system and give back results."""

from .assembly import assemble
from .inverse import inverse_dynamics
from .kinematic import kinematics
from .linearization import linearize
from .ode import ODE
from .simulation import simulate
from .statics import equilibrium
from .vibration import modes

__all__ = [
    "ODE",
    "assemble",
    "equilibrium",
    "inverse_dynamics",
    "kinematics",
    "linearize",
    "modes",
    "simulate",
]
