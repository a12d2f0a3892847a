"""The drivers: prescribed motions, one file each."""

from .angle import AngleDriver as AngleDriver
from .coordinate import CoordinateDriver as CoordinateDriver
from .distance import DistanceDriver as DistanceDriver
from .driver import Driver as Driver
from .point import PointDriver as PointDriver
from .travel import TravelDriver as TravelDriver
