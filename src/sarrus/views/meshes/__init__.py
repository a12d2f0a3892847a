"""Triangle meshes: the type, solids made from numbers, and those of files."""

from ...model.bodies.mesh_file import MeshError as MeshError
from .mesh import Facets as Facets
from .read import given_meshes as given_meshes
from .read import read_mesh as read_mesh
