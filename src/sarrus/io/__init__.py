"""Reading mechanisms that were written for other programs."""

from .by_ending import load_any as load_any
from .mjcf import load_mjcf as load_mjcf
from .robot import Robot as Robot
from .urdf import load_urdf as load_urdf
