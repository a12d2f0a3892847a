"""Analyses take a system and give back results; each is imported when it is first used."""

from typing import TYPE_CHECKING

from ..exports import on_demand

if TYPE_CHECKING:
    from .driven.inverse_dynamics import inverse_dynamics as inverse_dynamics
    from .driven.kinematics import kinematics as kinematics
    from .driven.singular_configurations import singularities as singularities
    from .dynamics import HHT as HHT
    from .dynamics import ODE as ODE
    from .dynamics import Event as Event
    from .dynamics import GeneralizedAlpha as GeneralizedAlpha
    from .dynamics import Impact as Impact
    from .dynamics import Radau as Radau
    from .dynamics import repeat as repeat
    from .dynamics import resume as resume
    from .dynamics import simulate as simulate
    from .dynamics.integrators.described import DescribedMethod as DescribedMethod
    from .dynamics.methods import Description as Description
    from .dynamics.methods import Equation as Equation
    from .dynamics.methods import Estimate as Estimate
    from .dynamics.methods import Stage as Stage
    from .dynamics.methods import Step as Step
    from .dynamics.run_options import Limits as Limits
    from .dynamics.run_options import Save as Save
    from .dynamics.sampled.controllers import Controller as Controller
    from .dynamics.sampled.stepper import Stepper as Stepper
    from .dynamics.stepping.step_control import StepControl as StepControl
    from .equilibria.state_space import linearize as linearize
    from .equilibria.statics import equilibrium as equilibrium
    from .equilibria.vibration import modes as modes
    from .forward.forward_dynamics import ForwardDynamics as ForwardDynamics
    from .forward.state_hessian import state_hessian as state_hessian
    from .optimization import Combined as Combined
    from .optimization import Problem as Problem
    from .optimization import Within as Within
    from .optimization import optimize as optimize
    from .optimization.fit import fit as fit
    from .position.assembly import assemble as assemble
    from .position.assembly_derivatives import AssemblyDerivatives as AssemblyDerivatives
    from .position.assembly_derivatives import NoDerivative as NoDerivative
    from .position.joint_space import JointSpace as JointSpace
    from .redundancy.degrees_of_freedom import mobility as mobility
    from .sensitivity import At as At
    from .sensitivity import AtEvent as AtEvent
    from .sensitivity import Final as Final
    from .sensitivity import Integral as Integral
    from .sensitivity import Maximum as Maximum
    from .sensitivity import Minimum as Minimum
    from .sensitivity import Misfit as Misfit
    from .sensitivity import Outputs as Outputs
    from .sensitivity import hessian_product as hessian_product
    from .sensitivity import sensitivity_by_checkpoints as sensitivity_by_checkpoints
    from .sensitivity import state_derivatives as state_derivatives
    from .sensitivity.hessian import hessian as hessian
    from .verification import verify as verify
    from .workspace import Dexterity as Dexterity
    from .workspace import WorkspaceMap as WorkspaceMap
    from .workspace import area_gradient as area_gradient
    from .workspace import distance_gradient as distance_gradient
    from .workspace import end_gradient as end_gradient
    from .workspace import input_singularities as input_singularities
    from .workspace import verify_workspace as verify_workspace
    from .workspace import volume_gradient as volume_gradient
    from .workspace import workspace_field as workspace_field
    from .workspace import workspace_range as workspace_range
    from .workspace import workspace_volume as workspace_volume
    from .workspace.dexterity import dexterity as dexterity
else:
    __getattr__ = on_demand(__name__, __file__)
