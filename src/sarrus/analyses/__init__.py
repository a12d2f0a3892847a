"""Analyses take a system and give back results."""

from .assembly import assemble
from .assembly_derivatives import AssemblyDerivatives, NoDerivative
from .degrees_of_freedom import mobility
from .dynamics import HHT, ODE, GeneralizedAlpha, simulate
from .joint_space import JointSpace
from .singular_positions import singularities

__all__ = [
    "HHT",
    "ODE",
    "AssemblyDerivatives",
    "GeneralizedAlpha",
    "JointSpace",
    "NoDerivative",
    "assemble",
    "mobility",
    "simulate",
    "singularities",
]
