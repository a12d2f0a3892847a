"""Elements: constraint primitives, inertias and forces of the paper, one file each, formulas only."""

from .bushing import Bushing
from .constant_angle import ConstantAngle
from .coordinate_driver import CoordinateDriver
from .coupling import AngleAngle, DisplacementAngle, DisplacementDisplacement
from .displacement import Displacement, DisplacementDriver
from .distance import Distance
from .distance_driver import DistanceDriver
from .dot1 import Dot1
from .dot2 import Dot2
from .drag import Drag, ViscousDrag
from .eccentric_inertia import EccentricInertia
from .element import Element, ElementError, Force, InertiaElement, Pair, Primitive, Single
from .gravity import EccentricGravity, Gravity
from .heading import Heading
from .joint_angle import Angle, AngleDriver
from .joint_friction import AngleFriction, DisplacementFriction
from .normalization import Normalization
from .operators import GROUPS, OPERATORS, Operator
from .output import output as output
from .point_force import FollowerForce, PointForce
from .rigid_inertia import RigidInertia
from .road_tyre import RoadTyre
from .rsda import RSDA, NonlinearRSDA
from .screw import Screw
from .sphere_contact import SphereContact
from .spherical import Spherical
from .stop import AngleStop, DisplacementStop, LengthStop
from .torque import BodyTorque, Torque
from .tsda import TSDA, NonlinearTSDA
from .tyre import Tyre
from .varying_force import VaryingFollowerForce, VaryingForce
from .varying_torque import VaryingBodyTorque, VaryingTorque

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
    "AngleFriction",
    "AngleStop",
    "BodyTorque",
    "Bushing",
    "ConstantAngle",
    "CoordinateDriver",
    "Displacement",
    "DisplacementAngle",
    "DisplacementDisplacement",
    "DisplacementDriver",
    "DisplacementFriction",
    "DisplacementStop",
    "Distance",
    "DistanceDriver",
    "Dot1",
    "Dot2",
    "Drag",
    "EccentricGravity",
    "EccentricInertia",
    "Element",
    "ElementError",
    "FollowerForce",
    "Force",
    "Gravity",
    "Heading",
    "InertiaElement",
    "LengthStop",
    "NonlinearRSDA",
    "NonlinearTSDA",
    "Normalization",
    "Operator",
    "Pair",
    "PointForce",
    "Primitive",
    "RigidInertia",
    "RoadTyre",
    "Screw",
    "Single",
    "SphereContact",
    "Spherical",
    "Torque",
    "Tyre",
    "VaryingBodyTorque",
    "VaryingFollowerForce",
    "VaryingForce",
    "VaryingTorque",
    "ViscousDrag",
    "output",
]
