"""Results are values: plain arrays with names."""

from .assembly import Assembly
from .joint_motion import JointMotion
from .trajectory import BodyMotion, Trajectory

__all__ = ["Assembly", "BodyMotion", "JointMotion", "Trajectory"]
