"""Workspaces: what outputs of a mechanism can reach, its boundary, barriers and singularities, by continuation."""

from ...model.deprecated import deprecated_function
from .analysis import checked_workspace, workspace
from .control import input_singularities
from .dexterity import Dexterity, dexterity, workspace_field
from .regions.mapping import WorkspaceMap
from .volumes.extremes import workspace_range
from .volumes.shape_derivatives import area_gradient, distance_gradient, end_gradient, volume_gradient
from .volumes.volume import workspace_volume

verify_workspace = deprecated_function("verify_workspace", "verify", checked_workspace)

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
