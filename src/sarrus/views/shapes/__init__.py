"""Triangle meshes that drawings are made of: balls, rods, plates, coils, and how they are placed."""

from .mesh import Mesh, joined, normals
from .plates import bar, box, hull, plate, toothed
from .rounds import arrow, ball, coil, cone, disc, rim, ring, rod, spiral, tube, wheel

__all__ = [
    "Mesh",
    "arrow",
    "ball",
    "bar",
    "box",
    "coil",
    "cone",
    "disc",
    "hull",
    "joined",
    "normals",
    "plate",
    "rim",
    "ring",
    "rod",
    "spiral",
    "toothed",
    "tube",
    "wheel",
]
