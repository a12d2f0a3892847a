"""Workspaces: what outputs of a mechanism can reach, its boundary, barriers and singularities, by continuation."""

from .analysis import workspace
from .control import input_singularities
from .dexterity import Dexterity, dexterity
from .extremes import workspace_range
from .field import workspace_field
from .mapping import WorkspaceMap
from .shape import area_gradient, distance_gradient, end_gradient, volume_gradient
from .verify import verify_workspace
from .volume import workspace_volume

__all__ = [
    "Dexterity",
    "WorkspaceMap",
    "area_gradient",
    "dexterity",
    "distance_gradient",
    "end_gradient",
    "input_singularities",
    "verify_workspace",
    "volume_gradient",
    "workspace",
    "workspace_field",
    "workspace_range",
    "workspace_volume",
]
