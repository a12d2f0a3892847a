"""Results are values: plain arrays with names."""

from .assembly import Asked, Assembly
from .equilibrium import Equilibrium
from .gradient import Gradient, Hessian, StateDerivatives
from .happened import Happened
from .input_singularities import InputSingularities, SingularCurve
from .joint_motion import JointMotion
from .mobility import Mobility, Repetition
from .modes import Modes
from .optimum import Optimum, StartReport
from .reaction import Reaction
from .reading import load_run
from .sequences import Product, ResultList, Singularities
from .shape import ShapeDerivative
from .singularity import Singularity
from .solution import NoSolution, Solution, State
from .steps import AlphaSteps, Pieces, RadauSteps, StabilizedSteps, Steps, StepsTaken, Turn
from .trajectory import BodyMotion, Trajectory
from .workspace import BoundaryCurve, Component, Effort, Verification, Workspace
from .workspace_field import WorkspaceField
from .workspace_range import CriticalValue, WorkspaceRange
from .workspace_volume import Slice, WorkspaceVolume

__all__ = [
    "AlphaSteps",
    "Asked",
    "Assembly",
    "BodyMotion",
    "BoundaryCurve",
    "Component",
    "CriticalValue",
    "Effort",
    "Equilibrium",
    "Gradient",
    "Happened",
    "Hessian",
    "InputSingularities",
    "JointMotion",
    "Mobility",
    "Modes",
    "NoSolution",
    "Optimum",
    "Pieces",
    "Product",
    "RadauSteps",
    "Reaction",
    "Repetition",
    "ResultList",
    "ShapeDerivative",
    "SingularCurve",
    "Singularities",
    "Singularity",
    "Slice",
    "Solution",
    "StabilizedSteps",
    "StartReport",
    "State",
    "StateDerivatives",
    "Steps",
    "StepsTaken",
    "Trajectory",
    "Turn",
    "Verification",
    "Workspace",
    "WorkspaceField",
    "WorkspaceRange",
    "WorkspaceVolume",
    "load_run",
]
