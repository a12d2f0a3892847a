"""MJCF, the model format of MuJoCo, read by the ``mujoco`` package."""

from .load import load_mjcf as load_mjcf
