"""The drivers: prescribed motions, one file each."""

from .coordinate import CoordinateDriver as CoordinateDriver
from .distance import DistanceDriver as DistanceDriver
from .driver import Driver as Driver
from .joint import AngleDriver as AngleDriver
from .joint import DisplacementDriver as DisplacementDriver
from .point import PointDriver as PointDriver
