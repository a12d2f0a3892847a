"""Multibody system analysis with exact derivatives.

    Model → System → analysis → result → view

A model is what you describe; a system is that model compiled to arrays; analyses take a system and return results,
which are values. Names are imported when they are first used, so that ``import sarrus`` is quick.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from . import rendering

if TYPE_CHECKING:
    from .analyses import HHT as HHT
    from .analyses import IDA as IDA
    from .analyses import ODE as ODE
    from .analyses import AssemblyDerivatives as AssemblyDerivatives
    from .analyses import At as At
    from .analyses import AtEvent as AtEvent
    from .analyses import Combined as Combined
    from .analyses import Event as Event
    from .analyses import Final as Final
    from .analyses import GeneralizedAlpha as GeneralizedAlpha
    from .analyses import Impact as Impact
    from .analyses import Integral as Integral
    from .analyses import JointSpace as JointSpace
    from .analyses import Maximum as Maximum
    from .analyses import Minimum as Minimum
    from .analyses import Misfit as Misfit
    from .analyses import NoDerivative as NoDerivative
    from .analyses import Outputs as Outputs
    from .analyses import Peak as Peak
    from .analyses import Problem as Problem
    from .analyses import Radau as Radau
    from .analyses import Within as Within
    from .analyses import WorkspaceMap as WorkspaceMap
    from .analyses import area_gradient as area_gradient
    from .analyses import assemble as assemble
    from .analyses import dexterity as dexterity
    from .analyses import distance_gradient as distance_gradient
    from .analyses import end_gradient as end_gradient
    from .analyses import equilibrium as equilibrium
    from .analyses import fit as fit
    from .analyses import hessian as hessian
    from .analyses import hessian_product as hessian_product
    from .analyses import input_singularities as input_singularities
    from .analyses import inverse_dynamics as inverse_dynamics
    from .analyses import kinematics as kinematics
    from .analyses import linearize as linearize
    from .analyses import mobility as mobility
    from .analyses import modes as modes
    from .analyses import optimize as optimize
    from .analyses import repeat as repeat
    from .analyses import resume as resume
    from .analyses import simulate as simulate
    from .analyses import singularities as singularities
    from .analyses import state_derivatives as state_derivatives
    from .analyses import verify_workspace as verify_workspace
    from .analyses import volume_gradient as volume_gradient
    from .analyses.sensitivity import sensitivity as sensitivity
    from .analyses.sensitivity import sensitivity_by_checkpoints as sensitivity_by_checkpoints
    from .analyses.workspace import workspace as workspace
    from .analyses.workspace import workspace_field as workspace_field
    from .analyses.workspace import workspace_range as workspace_range
    from .analyses.workspace import workspace_volume as workspace_volume
    from .io import Robot as Robot
    from .io import load_any as load_any
    from .io import load_mjcf as load_mjcf
    from .io import load_urdf as load_urdf
    from .model import RSDA as RSDA
    from .model import TSDA as TSDA
    from .model import AngleDriver as AngleDriver
    from .model import AngleFriction as AngleFriction
    from .model import AngleStop as AngleStop
    from .model import AxisAngle as AxisAngle
    from .model import Body as Body
    from .model import Bushing as Bushing
    from .model import ConstantAngle as ConstantAngle
    from .model import CoordinateDriver as CoordinateDriver
    from .model import Coupler as Coupler
    from .model import Curve as Curve
    from .model import Cylindrical as Cylindrical
    from .model import DisplacementDriver as DisplacementDriver
    from .model import DisplacementFriction as DisplacementFriction
    from .model import DisplacementStop as DisplacementStop
    from .model import Distance as Distance
    from .model import DistanceDriver as DistanceDriver
    from .model import Drag as Drag
    from .model import Driver as Driver
    from .model import EulerAngles as EulerAngles
    from .model import Fixed as Fixed
    from .model import Formula as Formula
    from .model import Frame as Frame
    from .model import Gear as Gear
    from .model import Length as Length
    from .model import LengthStop as LengthStop
    from .model import Model as Model
    from .model import ModelError as ModelError
    from .model import ParallelAxes as ParallelAxes
    from .model import Planar as Planar
    from .model import Point as Point
    from .model import PointCoordinate as PointCoordinate
    from .model import PointDriver as PointDriver
    from .model import PointForce as PointForce
    from .model import PointOnLine as PointOnLine
    from .model import PointOnPlane as PointOnPlane
    from .model import RackAndPinion as RackAndPinion
    from .model import Revolute as Revolute
    from .model import RevoluteRevolute as RevoluteRevolute
    from .model import RevoluteSpherical as RevoluteSpherical
    from .model import RoadTyre as RoadTyre
    from .model import SarrusError as SarrusError
    from .model import SarrusWarning as SarrusWarning
    from .model import Screw as Screw
    from .model import Shape as Shape
    from .model import SphereContact as SphereContact
    from .model import Spherical as Spherical
    from .model import StrictError as StrictError
    from .model import Torque as Torque
    from .model import Translational as Translational
    from .model import Turn as Turn
    from .model import Tyre as Tyre
    from .model import Universal as Universal
    from .model import ViscousDrag as ViscousDrag
    from .model import describe as describe
    from .model import ground as ground
    from .model import load as load
    from .model import parse_expression as parse_expression
    from .results import Assembly as Assembly
    from .results import Equilibrium as Equilibrium
    from .results import EventRecord as EventRecord
    from .results import Gradient as Gradient
    from .results import Hessian as Hessian
    from .results import InputSingularities as InputSingularities
    from .results import Mobility as Mobility
    from .results import Modes as Modes
    from .results import Optimum as Optimum
    from .results import Reaction as Reaction
    from .results import ShapeDerivative as ShapeDerivative
    from .results import Singularity as Singularity
    from .results import Solution as Solution
    from .results import State as State
    from .results import Trajectory as Trajectory
    from .results import Workspace as Workspace
    from .results import WorkspaceField as WorkspaceField
    from .results import WorkspaceRange as WorkspaceRange
    from .results import WorkspaceVolume as WorkspaceVolume
    from .results import load_run as load_run
    from .studies import Distribution as Distribution
    from .studies import Grid as Grid
    from .studies import Kinematics as Kinematics
    from .studies import LatinHypercube as LatinHypercube
    from .studies import Listed as Listed
    from .studies import MonteCarlo as MonteCarlo
    from .studies import Range as Range
    from .studies import Simulation as Simulation
    from .studies import Sobol as Sobol
    from .studies import Statics as Statics
    from .studies import StudyTable as StudyTable
    from .studies import Uncertainty as Uncertainty
    from .studies import Values as Values
    from .studies import Vibration as Vibration
    from .studies import open_study as open_study
    from .studies import study as study
    from .studies import uncertainty as uncertainty
    from .system import System as System
    from .views import animate as animate
    from .views import view as view

__version__ = "0.1.0"

_HOMES = {
    "model": (
        "AngleDriver AngleFriction AngleStop AxisAngle Body Bushing ConstantAngle CoordinateDriver Coupler "
        "Curve Cylindrical DisplacementDriver DisplacementFriction DisplacementStop Distance DistanceDriver "
        "Drag Driver EulerAngles Fixed Formula Frame Gear Length "
        "LengthStop Model ModelError ParallelAxes Planar Point PointCoordinate PointDriver PointForce "
        "PointOnLine PointOnPlane RSDA RackAndPinion Revolute RevoluteRevolute RevoluteSpherical RoadTyre "
        "SarrusError SarrusWarning Screw Shape SphereContact Spherical StrictError TSDA Torque Translational "
        "Turn Tyre Universal ViscousDrag describe ground load parse_expression"
    ),
    "system": "System",
    "analyses": (
        "AssemblyDerivatives At AtEvent Combined Event Final GeneralizedAlpha HHT IDA Impact Integral JointSpace "
        "Maximum Minimum Misfit NoDerivative ODE Outputs Peak Problem Radau Within WorkspaceMap "
        "area_gradient assemble dexterity distance_gradient end_gradient equilibrium fit hessian hessian_product "
        "input_singularities inverse_dynamics "
        "kinematics linearize mobility modes optimize repeat resume sensitivity sensitivity_by_checkpoints "
        "simulate singularities "
        "state_derivatives verify_workspace volume_gradient workspace workspace_field workspace_range "
        "workspace_volume"
    ),
    "io": "Robot load_any load_mjcf load_urdf",
    "results": (
        "Assembly Equilibrium EventRecord Gradient Hessian InputSingularities Mobility Modes Optimum Reaction "
        "ShapeDerivative Singularity Solution State Trajectory Workspace WorkspaceField WorkspaceRange "
        "WorkspaceVolume load_run"
    ),
    "views": "animate view",
    "studies": (
        "Distribution Grid Kinematics LatinHypercube Listed MonteCarlo Range Simulation Sobol Statics "
        "StudyTable Uncertainty Values Vibration open_study study uncertainty"
    ),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names.split()}

__all__ = [*sorted(_HOME_OF), "__version__"]  # pyright: ignore[reportUnsupportedDunderAll]


rendering.register(lambda: import_module(".views", __name__))


def __getattr__(name: str) -> Any:
    if name in _HOME_OF:
        globals()[name] = value = getattr(import_module(f".{_HOME_OF[name]}", __name__), name)
        return value
    present = import_module(".model.checks.deprecated", __name__).present_class(name)
    if present == name:
        raise AttributeError(f"module 'sarrus' has no attribute {name!r}")
    return getattr(import_module(__name__), present)


def __dir__() -> list[str]:
    return __all__
