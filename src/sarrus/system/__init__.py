"""A model compiled to arrays: index maps, sparse patterns, operators."""

from .check import Finding, Report
from .group import Group
from .system import System

__all__ = ["Finding", "Group", "Report", "System"]
