"""Robots: the content of robot descriptions, independent of the format, and the models built from it."""

from .build import build as build
from .description import Activation as Activation
from .description import Actuator as Actuator
from .description import Contraction as Contraction
from .description import Description as Description
from .description import Dynamics as Dynamics
from .description import Edge as Edge
from .description import Inertia as Inertia
from .description import Limit as Limit
from .description import Link as Link
from .description import Mimic as Mimic
from .description import MuscleDynamics as MuscleDynamics
from .description import Obstacle as Obstacle
from .description import Path as Path
from .description import Sensor as Sensor
from .description import Stop as Stop
from .description import TendonEquality as TendonEquality
from .description import TendonForces as TendonForces
from .description import Visual as Visual
from .description import Wrench as Wrench
from .loads.actuators import activation_name as activation_name
from .options import ImportOptions as ImportOptions
from .robot import Keyframe as Keyframe
from .robot import Robot as Robot
