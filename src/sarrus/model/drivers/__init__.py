"""The drivers, prescribed motions. A file of this folder is found without a list: its classes register themselves."""

from ...registration import import_modules
from .driver import Driver as Driver

import_modules(__name__, __path__)
