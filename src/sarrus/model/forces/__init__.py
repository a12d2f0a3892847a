"""The forces: one file each."""

from .bushing import Bushing as Bushing
from .contact import AngleStop as AngleStop
from .contact import DisplacementStop as DisplacementStop
from .contact import LengthStop as LengthStop
from .contact import SphereContact as SphereContact
from .drag import Drag as Drag
from .drag import ViscousDrag as ViscousDrag
from .force import Force as Force
from .joint_friction import AngleFriction as AngleFriction
from .joint_friction import DisplacementFriction as DisplacementFriction
from .loads import PointForce as PointForce
from .loads import Torque as Torque
from .rsda import RSDA as RSDA
from .tsda import TSDA as TSDA
from .tyre import RoadTyre as RoadTyre
from .tyre import Tyre as Tyre
