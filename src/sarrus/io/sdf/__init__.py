"""SDF, the description format of Gazebo, read with the standard library alone."""

from .load import load_sdf as load_sdf
