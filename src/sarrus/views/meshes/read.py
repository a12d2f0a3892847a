"""A mesh file of any kind that is known, as triangles with their colours."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import lru_cache
from pathlib import Path

import numpy as np

from .bounds import bounded
from .colored import Colored, MeshError
from .dae import read_dae
from .gltf import read_gltf
from .obj import read_obj
from .stl import read_stl
from .thin import thinned

READERS: dict[str, Callable[[Path], Iterable[Colored]]] = {
    ".stl": read_stl,
    ".obj": read_obj,
    ".gltf": read_gltf,
    ".glb": read_gltf,
    ".dae": read_dae,
}

DAMAGED = (ValueError, LookupError, TypeError, AttributeError, ArithmeticError, RuntimeError, MemoryError)


@lru_cache(maxsize=64)
def read_mesh(file: Path) -> list[Colored]:
    """Return the parts of a mesh file, large ones thinned.

    Raises
    ------
    MeshError
        If there is no such file, or its content cannot be read, in one message.
    """
    reader = READERS.get(file.suffix.lower())
    if reader is None:
        raise MeshError(f"{file}: meshes must end in {', '.join(READERS)}; convert it")
    try:
        with np.errstate(all="ignore"):
            return [Colored(thinned(mesh), color) for mesh, color in bounded(reader(file))]
    except FileNotFoundError:
        raise MeshError(f"{file}: does not exist; check the path") from None
    except OSError as error:
        raise MeshError(f"{file}: {(error.strerror or str(error)).lower()}; check the path") from None
    except DAMAGED as error:
        raise MeshError(f"{file}: is no mesh that can be read ({error}); export it again") from None
