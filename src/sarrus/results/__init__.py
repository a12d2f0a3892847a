"""Results are values: frozen dataclasses of plain arrays with names.

Here are the results of analyses at one position and of searches; those over time are in `motion`, those of workspaces
in `maps`. `saving` reads and writes runs and other files.
"""

from .assembly import Asked, Assembly
from .equilibrium import Equilibrium
from .error_estimate import ErrorEstimate
from .gradient import Gradient, Hessian, StateDerivatives
from .maps.input_singularities import InputSingularities, SingularCurve
from .maps.shape import ShapeDerivative
from .maps.workspace import BoundaryCurve, Component, Effort, Verification, Workspace
from .maps.workspace_field import WorkspaceField
from .maps.workspace_range import CriticalValue, WorkspaceRange
from .maps.workspace_volume import Slice, WorkspaceVolume
from .mobility import Mobility, Repetition
from .modes import Modes
from .motion.energy_balance import EnergyBalance
from .motion.events import EventRecord
from .motion.part_motion import PartMotion
from .motion.parts import BodyMotion, JointMotion, Reaction
from .motion.solution import NoSolution, Solution, State
from .motion.steps import EventStep, Pieces, StepsTaken
from .motion.trajectory import Trajectory
from .optimum import Optimum, StartReport
from .reading import load_run
from .result import Product, ResultList
from .singularity import Singularities, Singularity

__all__ = [
    "Asked",
    "Assembly",
    "BodyMotion",
    "BoundaryCurve",
    "Component",
    "CriticalValue",
    "Effort",
    "EnergyBalance",
    "Equilibrium",
    "ErrorEstimate",
    "EventRecord",
    "EventStep",
    "Gradient",
    "Hessian",
    "InputSingularities",
    "JointMotion",
    "Mobility",
    "Modes",
    "NoSolution",
    "Optimum",
    "PartMotion",
    "Pieces",
    "Product",
    "Reaction",
    "Repetition",
    "ResultList",
    "ShapeDerivative",
    "SingularCurve",
    "Singularities",
    "Singularity",
    "Slice",
    "Solution",
    "StartReport",
    "State",
    "StateDerivatives",
    "StepsTaken",
    "Trajectory",
    "Verification",
    "Workspace",
    "WorkspaceField",
    "WorkspaceRange",
    "WorkspaceVolume",
    "load_run",
]
