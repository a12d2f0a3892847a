"""Triangle meshes: the type, solids made from numbers, and files (STL, OBJ, glTF, COLLADA) read within strict limits.

Nothing here knows models or bodies; a file needs NumPy and the standard library only.
"""

from .colored import Colored as Colored
from .colored import MeshError as MeshError
from .read import given_meshes as given_meshes
from .read import read_mesh as read_mesh
