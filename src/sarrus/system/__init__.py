"""A model compiled to arrays: index maps, sparse patterns, operators."""

from .check import Finding, Report
from .group import Group
from .joints import JointCoordinate, JointCoordinates, SystemJoint
from .system import System

__all__ = ["Finding", "Group", "JointCoordinate", "JointCoordinates", "Report", "System", "SystemJoint"]
