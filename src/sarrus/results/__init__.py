"""Results are values: plain arrays with names."""

from .assembly import Assembly
from .equilibrium import Equilibrium
from .joint_motion import JointMotion
from .modes import Modes
from .reaction import Reaction
from .trajectory import BodyMotion, Trajectory

__all__ = ["Assembly", "BodyMotion", "Equilibrium", "JointMotion", "Modes", "Reaction", "Trajectory"]
