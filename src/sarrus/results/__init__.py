"""Results are values: plain arrays with names."""

from .assembly import Assembly
from .trajectory import BodyMotion, Trajectory

__all__ = ["Assembly", "BodyMotion", "Trajectory"]
