"""Reading mechanisms that were written for other programs: URDF, SDF, MJCF, and their side files.

`urdf`, `sdf` and `mjcf` each make a description of a file, `robot` a model of a description. Sarrus' own model files
are read by `sarrus.model.file`. An importer is found without a list: it registers itself with `importer`.
"""

from ..registration import import_modules
from .by_ending import importer as importer
from .by_ending import load_any as load_any
from .export import export as export
from .mjcf import load_mjcf as load_mjcf
from .road import load_road as load_road
from .robot import Robot as Robot
from .sdf import load_sdf as load_sdf
from .tir import TyreFile as TyreFile
from .tir import load_tyre as load_tyre
from .tyre_fit import TyreFit as TyreFit
from .urdf import load_urdf as load_urdf

import_modules(__name__, __path__)
