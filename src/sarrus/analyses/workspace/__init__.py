"""Workspaces: what outputs of a mechanism can reach, its boundary, barriers and singularities, by continuation."""

from .analysis import workspace
from .mapping import WorkspaceMap
from .verify import verify_workspace

__all__ = ["WorkspaceMap", "verify_workspace", "workspace"]
