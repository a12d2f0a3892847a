"""A model compiled to arrays: index maps, sparse patterns, operators."""

from .check import Finding, Report
from .operators.joints import JointCoordinate, JointCoordinates, SystemJoint
from .structure.group import Group
from .system import System

__all__ = ["Finding", "Group", "JointCoordinate", "JointCoordinates", "Report", "System", "SystemJoint"]
