"""Results are values: plain arrays with names."""

from .assembly import Asked, Assembly
from .mobility import Mobility, Repetition
from .trajectory import BodyMotion, Trajectory

__all__ = ["Asked", "Assembly", "BodyMotion", "Mobility", "Repetition", "Trajectory"]
