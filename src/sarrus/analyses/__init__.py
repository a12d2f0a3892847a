"""Analyses take a system and give back results."""

from .assembly import assemble
from .assembly_derivatives import AssemblyDerivatives, NoDerivative
from .degrees_of_freedom import mobility
from .dynamics import HHT, IDA, ODE, Event, GeneralizedAlpha, Impact, Radau, simulate
from .inverse import inverse_dynamics
from .joint_space import JointSpace
from .kinematic import kinematics
from .linearization import linearize
from .singular_positions import singularities
from .statics import equilibrium
from .vibration import modes

__all__ = [
    "HHT",
    "IDA",
    "ODE",
    "AssemblyDerivatives",
    "Event",
    "GeneralizedAlpha",
    "Impact",
    "JointSpace",
    "NoDerivative",
    "Radau",
    "assemble",
    "equilibrium",
    "inverse_dynamics",
    "kinematics",
    "linearize",
    "mobility",
    "modes",
    "simulate",
    "singularities",
]
