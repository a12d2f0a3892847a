"""Results are values: frozen dataclasses of plain arrays with names.

Here are the results of analyses at one position and of searches; those over time are in `motion`, those of workspaces
in `maps`. `saving` reads and writes runs and other files.
"""

from typing import TYPE_CHECKING

from ..exports import on_demand

if TYPE_CHECKING:
    from .assembly import Assembly as Assembly
    from .assembly import AssemblyRequest as AssemblyRequest
    from .comparison import ComparedValue as ComparedValue
    from .comparison import Comparison as Comparison
    from .equilibrium import Equilibrium as Equilibrium
    from .error_estimate import ErrorEstimate as ErrorEstimate
    from .frequency_response import FrequencyResponse as FrequencyResponse
    from .gradient import Gradient as Gradient
    from .gradient import Hessian as Hessian
    from .gradient import StateDerivatives as StateDerivatives
    from .maps.input_singularities import InputSingularities as InputSingularities
    from .maps.input_singularities import SingularCurve as SingularCurve
    from .maps.workspace import BoundaryCurve as BoundaryCurve
    from .maps.workspace import Component as Component
    from .maps.workspace import Verification as Verification
    from .maps.workspace import Workspace as Workspace
    from .maps.workspace_field import WorkspaceField as WorkspaceField
    from .maps.workspace_volume import CriticalValue as CriticalValue
    from .maps.workspace_volume import ShapeDerivative as ShapeDerivative
    from .maps.workspace_volume import Slice as Slice
    from .maps.workspace_volume import WorkspaceRange as WorkspaceRange
    from .maps.workspace_volume import WorkspaceVolume as WorkspaceVolume
    from .mobility import Mobility as Mobility
    from .mobility import Repetition as Repetition
    from .modes import Modes as Modes
    from .motion.energy_balance import EnergyBalance as EnergyBalance
    from .motion.events import EventRecord as EventRecord
    from .motion.part_motion import PartMotion as PartMotion
    from .motion.parts import BodyMotion as BodyMotion
    from .motion.parts import JointMotion as JointMotion
    from .motion.parts import Reaction as Reaction
    from .motion.solution import NoSolution as NoSolution
    from .motion.solution import Solution as Solution
    from .motion.solution import State as State
    from .motion.steps import EventStep as EventStep
    from .motion.steps import Segments as Segments
    from .motion.steps import StepsTaken as StepsTaken
    from .motion.trajectory import Trajectory as Trajectory
    from .optimum import Optimum as Optimum
    from .optimum import StartReport as StartReport
    from .reading import load_run as load_run
    from .result import Product as Product
    from .result import ResultList as ResultList
    from .singularity import Singularities as Singularities
    from .singularity import Singularity as Singularity
    from .state_space import StateSpace as StateSpace
else:
    __getattr__ = on_demand(__name__, __file__)
