"""Meshes from files: STL, OBJ, glTF and COLLADA, read with NumPy and the standard library."""

from .colored import Colored, MeshError
from .read import read_mesh

__all__ = ["Colored", "MeshError", "read_mesh"]
