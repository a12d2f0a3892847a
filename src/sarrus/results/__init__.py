"""Results are values: plain arrays with names."""

from .assembly import Asked, Assembly
from .joint_motion import JointMotion
from .mobility import Mobility, Repetition
from .singularity import Singularity
from .trajectory import BodyMotion, Trajectory

__all__ = [
    "Asked",
    "Assembly",
    "BodyMotion",
    "JointMotion",
    "Mobility",
    "Repetition",
    "Singularity",
    "Trajectory",
]
