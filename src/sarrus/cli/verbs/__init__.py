"""The verbs of the command line: one verb, one file of this folder, found by its name."""

import sys

from ...registration import import_modules
from ..parser import VERBS

VERBS.update({name: sys.modules[f"{__name__}.{name}"] for name in import_modules(__name__, __path__)})
