"""The joints: one file each."""

from .cylindrical import Cylindrical as Cylindrical
from .distance import Distance as Distance
from .fixed import Fixed as Fixed
from .joint import Joint as Joint
from .revolute import Revolute as Revolute
from .spherical import Spherical as Spherical
from .translational import Translational as Translational
from .universal import Universal as Universal
