"""Writing models as MJCF, URDF and SDF files for other programs."""

from .save import export as export
