"""The joints: one file each."""

from .constant_angle import ConstantAngle as ConstantAngle
from .couplings import Coupler as Coupler
from .couplings import Gear as Gear
from .couplings import RackAndPinion as RackAndPinion
from .cylindrical import Cylindrical as Cylindrical
from .fixed import Fixed as Fixed
from .joint import Joint as Joint
from .links import Distance as Distance
from .links import RevoluteRevolute as RevoluteRevolute
from .links import RevoluteSpherical as RevoluteSpherical
from .parallel_axes import ParallelAxes as ParallelAxes
from .planar import Planar as Planar
from .point_on import PointOnLine as PointOnLine
from .point_on import PointOnPlane as PointOnPlane
from .revolute import Revolute as Revolute
from .screw import Screw as Screw
from .spherical import Spherical as Spherical
from .translational import Translational as Translational
from .universal import Universal as Universal
