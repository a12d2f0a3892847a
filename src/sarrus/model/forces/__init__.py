"""The forces: one file each."""

from .bushing import Bushing as Bushing
from .drag import Drag as Drag
from .drag import ViscousDrag as ViscousDrag
from .force import Force as Force
from .joint_friction import AngleFriction as AngleFriction
from .joint_friction import TravelFriction as TravelFriction
from .point_force import PointForce as PointForce
from .road_tyre import RoadTyre as RoadTyre
from .rsda import RSDA as RSDA
from .sphere_contact import SphereContact as SphereContact
from .stop import AngleStop as AngleStop
from .stop import LengthStop as LengthStop
from .stop import TravelStop as TravelStop
from .torque import Torque as Torque
from .tsda import TSDA as TSDA
from .tyre import Tyre as Tyre
