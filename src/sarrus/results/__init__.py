"""Results are values: plain arrays with names."""

from .assembly import Asked, Assembly
from .equilibrium import Equilibrium
from .gradient import Gradient, StateDerivatives
from .happened import Happened
from .joint_motion import JointMotion
from .mobility import Mobility, Repetition
from .modes import Modes
from .optimum import Optimum
from .reaction import Reaction
from .reading import load_run
from .singularity import Singularity
from .solution import Solution, State
from .steps import Steps
from .trajectory import BodyMotion, Trajectory
from .workspace import BoundaryCurve, Component, Effort, Verification, Workspace

__all__ = [
    "Asked",
    "Assembly",
    "BodyMotion",
    "BoundaryCurve",
    "Component",
    "Effort",
    "Equilibrium",
    "Gradient",
    "Happened",
    "JointMotion",
    "Mobility",
    "Modes",
    "Optimum",
    "Reaction",
    "Repetition",
    "Singularity",
    "Solution",
    "State",
    "StateDerivatives",
    "Steps",
    "Trajectory",
    "Verification",
    "Workspace",
    "load_run",
]
