"""What the paper derives: constraint primitives, inertias and forces, one file each, formulas only."""

from .bushing import Bushing
from .distance import Distance
from .dot1 import Dot1
from .dot2 import Dot2
from .drag import Drag, ViscousDrag
from .eccentric_inertia import EccentricInertia
from .element import Element, ElementError, Force, InertiaElement, Pair, Primitive, Single
from .gravity import EccentricGravity, Gravity
from .joint_friction import AngleFriction, TravelFriction
from .normalization import Normalization
from .operators import GROUPS, OPERATORS, Operator
from .point_force import FollowerForce, PointForce
from .rigid_inertia import RigidInertia
from .road_tyre import RoadTyre
from .rsda import RSDA, NonlinearRSDA
from .sphere_contact import SphereContact
from .spherical import Spherical
from .stop import AngleStop, LengthStop, TravelStop
from .torque import BodyTorque, Torque
from .tsda import TSDA, NonlinearTSDA
from .tyre import Tyre
from .varying_force import VaryingFollowerForce, VaryingForce
from .varying_torque import VaryingBodyTorque, VaryingTorque

BUILT_IN: tuple[type[Element], ...] = tuple(Element.registry.values())
RARE = (
    AngleFriction, AngleStop, Bushing, Drag, LengthStop, NonlinearRSDA, RoadTyre, SphereContact, TravelFriction,
    TravelStop, VaryingBodyTorque, VaryingFollowerForce, VaryingForce, VaryingTorque, ViscousDrag,
)  # fmt: skip
COMMON: tuple[type[Element], ...] = tuple(kind for kind in BUILT_IN if kind not in RARE)
"""What is compiled together, for every system; the others are compiled when a model first has them."""

__all__ = [
    "BUILT_IN",
    "COMMON",
    "GROUPS",
    "OPERATORS",
    "RSDA",
    "TSDA",
    "AngleFriction",
    "AngleStop",
    "BodyTorque",
    "Bushing",
    "Distance",
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
    "Single",
    "SphereContact",
    "Spherical",
    "Torque",
    "TravelFriction",
    "TravelStop",
    "Tyre",
    "VaryingBodyTorque",
    "VaryingFollowerForce",
    "VaryingForce",
    "VaryingTorque",
    "ViscousDrag",
]
