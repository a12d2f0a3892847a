"""The joints: one file each."""

from .constant_angle import ConstantAngle as ConstantAngle
from .coupler import Coupler as Coupler
from .cylindrical import Cylindrical as Cylindrical
from .distance import Distance as Distance
from .fixed import Fixed as Fixed
from .gear import Gear as Gear
from .joint import Joint as Joint
from .parallel_axes import ParallelAxes as ParallelAxes
from .planar import Planar as Planar
from .point_on_line import PointOnLine as PointOnLine
from .point_on_plane import PointOnPlane as PointOnPlane
from .rack_and_pinion import RackAndPinion as RackAndPinion
from .revolute import Revolute as Revolute
from .revolute_revolute import RevoluteRevolute as RevoluteRevolute
from .revolute_spherical import RevoluteSpherical as RevoluteSpherical
from .screw import Screw as Screw
from .spherical import Spherical as Spherical
from .translational import Translational as Translational
from .universal import Universal as Universal
