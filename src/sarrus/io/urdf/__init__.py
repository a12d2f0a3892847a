"""URDF, the robot description of ROS, read with the standard library alone."""

from .load import load_urdf as load_urdf
