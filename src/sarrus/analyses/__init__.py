"""Analyses take a system and give back results."""

from .driven.inverse_dynamics import inverse_dynamics
from .driven.kinematics import kinematics
from .driven.singular_configurations import singularities
from .dynamics import HHT, IDA, ODE, Event, GeneralizedAlpha, Impact, Radau, repeat, resume, simulate
from .equilibria.linearization import linearize
from .equilibria.statics import equilibrium
from .equilibria.vibration import modes
from .optimization import Combined, Problem, Within, fit, optimize
from .position.assembly import assemble
from .position.assembly_derivatives import AssemblyDerivatives, NoDerivative
from .position.joint_space import JointSpace
from .redundancy.degrees_of_freedom import mobility
from .sensitivity import (
    At,
    AtEvent,
    Final,
    Integral,
    Maximum,
    Minimum,
    Misfit,
    Outputs,
    Peak,
    hessian,
    hessian_product,
    sensitivity,
    sensitivity_by_checkpoints,
    state_derivatives,
)
from .workspace import (
    Dexterity,
    WorkspaceMap,
    dexterity,
    input_singularities,
    verify_workspace,
    workspace,
    workspace_field,
    workspace_range,
    workspace_volume,
)
from .workspace import area_gradient as area_gradient
from .workspace import distance_gradient as distance_gradient
from .workspace import end_gradient as end_gradient
from .workspace import volume_gradient as volume_gradient

__all__ = [
    "HHT",
    "IDA",
    "ODE",
    "AssemblyDerivatives",
    "At",
    "AtEvent",
    "Combined",
    "Dexterity",
    "Event",
    "Final",
    "GeneralizedAlpha",
    "Impact",
    "Integral",
    "JointSpace",
    "Maximum",
    "Minimum",
    "Misfit",
    "NoDerivative",
    "Outputs",
    "Peak",
    "Problem",
    "Radau",
    "Within",
    "WorkspaceMap",
    "area_gradient",
    "assemble",
    "dexterity",
    "distance_gradient",
    "end_gradient",
    "equilibrium",
    "fit",
    "hessian",
    "hessian_product",
    "input_singularities",
    "inverse_dynamics",
    "kinematics",
    "linearize",
    "mobility",
    "modes",
    "optimize",
    "repeat",
    "resume",
    "sensitivity",
    "sensitivity_by_checkpoints",
    "simulate",
    "singularities",
    "state_derivatives",
    "verify_workspace",
    "volume_gradient",
    "workspace",
    "workspace_field",
    "workspace_range",
    "workspace_volume",
]
