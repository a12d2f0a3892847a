"""The forces: one file each."""

from .force import Force as Force
from .point_force import PointForce as PointForce
from .rsda import RSDA as RSDA
from .torque import Torque as Torque
from .tsda import TSDA as TSDA
from .tyre import Tyre as Tyre
