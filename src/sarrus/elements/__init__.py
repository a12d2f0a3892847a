"""What the paper derives: constraint primitives, inertias and forces, one file each, formulas only."""

from .constant_angle import ConstantAngle
from .coordinate_driver import CoordinateDriver
from .coupling import AngleAngle, TravelAngle, TravelTravel
from .distance import Distance
from .distance_driver import DistanceDriver
from .dot1 import Dot1
from .dot2 import Dot2
from .eccentric_inertia import EccentricInertia
from .element import Element, ElementError, Force, InertiaElement, Pair, Primitive, Single
from .gravity import EccentricGravity, Gravity
from .joint_angle import Angle, AngleDriver
from .normalization import Normalization
from .operators import GROUPS, OPERATORS, Operator
from .point_force import FollowerForce, PointForce
from .rigid_inertia import RigidInertia
from .rsda import RSDA
from .screw import Screw
from .spherical import Spherical
from .torque import BodyTorque, Torque
from .travel import Travel, TravelDriver
from .tsda import TSDA, NonlinearTSDA
from .tyre import Tyre

BUILT_IN: tuple[type[Element], ...] = tuple(Element.registry.values())

__all__ = [
    "BUILT_IN",
    "GROUPS",
    "OPERATORS",
    "RSDA",
    "TSDA",
    "Angle",
    "AngleAngle",
    "AngleDriver",
    "BodyTorque",
    "ConstantAngle",
    "CoordinateDriver",
    "Distance",
    "DistanceDriver",
    "Dot1",
    "Dot2",
    "EccentricGravity",
    "EccentricInertia",
    "Element",
    "ElementError",
    "FollowerForce",
    "Force",
    "Gravity",
    "InertiaElement",
    "NonlinearTSDA",
    "Normalization",
    "Operator",
    "Pair",
    "PointForce",
    "Primitive",
    "RigidInertia",
    "Screw",
    "Single",
    "Spherical",
    "Torque",
    "Travel",
    "TravelAngle",
    "TravelDriver",
    "TravelTravel",
    "Tyre",
]
